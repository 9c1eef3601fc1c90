// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/slam/graph/trajectory_graph.hpp"
#include "swiftlet/core/base/samples.hpp"
#include "swiftlet/core/slam/global_slam_config.hpp"

namespace swiftlet {

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
