// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/slam/graph/trajectory_graph.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/base/samples.hpp"
#include "swiftlet/core/slam/global_slam_config.hpp"
#include "swiftlet/core/slam/graph_config.hpp"

namespace swiftlet {

/// a / sigma + b along each axis [Orsulic 2021, eq. 7].
Vector3 gnss_weight_1_m(const GnssFactorConfig& config, const Vector3& sigma_world_m);

/// A point of a trajectory and its measured position.
struct MatchedPosition {
  Vector3 p_local_m = Vector3::Zero(), p_world_m = Vector3::Zero();
  double weight = 1.0;
};
/// Least-squares pose of the local frame in the world, over heading and translation: both have z up. The heading stays
/// `yaw_rad` when the spread of the points is too small to determine it.
Pose fit_to_world(std::span<const MatchedPosition> points, double yaw_rad, double least_spread_m);

/// GNSS fixes as factors of the pose graph, and the fit of an unknown start to them [Orsulic 2021, sec. III-C].
class GnssFactors {
 public:
  /// @param fits_start  true: the start pose is unknown and is fitted to the fixes
  GnssFactors(const GlobalSlamConfig& config, bool fits_start) : config_(config), fits_start_(fits_start) {}

  void add(const GnssSample& sample, const TrajectoryGraph& trajectory);
  /// Adds the last fix before the newest node; it stands for all fixes since the node before. Fixes may be newer than
  /// the nodes, whose scans arrive later.
  /// @return true when a factor was added
  bool place(TrajectoryGraph& trajectory);
  /// Fits an unknown start to east, north and up once the path is long enough to determine a heading.
  void fit_start(TrajectoryGraph& trajectory);

 private:
  GlobalSlamConfig config_;
  bool fits_start_;
  std::vector<GnssSample> waiting_;  // fixes newer than the last node
  std::vector<MatchedPosition> matched_;
};

}  // namespace swiftlet
