// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/slam/graph/gnss_factors.hpp"
#include "core/slam/graph/loop_closer.hpp"
#include "core/slam/graph/submap_memory.hpp"
#include "core/slam/graph/submap_provider.hpp"
#include "core/slam/graph/trajectory_graph.hpp"
#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/base/overlay.hpp"
#include "swiftlet/core/base/samples.hpp"
#include "swiftlet/core/localization/local_poses.hpp"
#include "swiftlet/core/map/submap_poses.hpp"
#include "swiftlet/core/math/latency.hpp"
#include "swiftlet/core/slam/global_slam_config.hpp"

namespace swiftlet {

/// Estimates the pose of the local frame in the world. Key frames (nodes) and submaps of the local trajectory are poses
/// of a graph, with closures at revisited places and GNSS fixes where available as factors.
///
/// The graph is bounded at one place: visits_kept submaps stay. A further one is dropped when it is finished; only its
/// pose and closures stay, until the next submap is finished.
///
/// With a map of an earlier flight, the graph starts as a copy of the earlier graph. With a known start pose, the
/// earlier submaps are closure candidates like those of this flight. With an unknown start pose, the vehicle is
/// relocalized in all earlier submaps.
class GlobalSlam : public SubmapProvider {
 public:
  /// @param pose_known  false: the start pose is a guess that GNSS may replace
  GlobalSlam(const GlobalSlamConfig& config, bool pose_known);

  /// Adds a scan registered by local SLAM, in order of time.
  /// @param T_world_local  present correction, which places the first node
  void add_scan(TimeNs t, const Pose& T_local_body, std::span<const Eigen::Vector3f> points_body_m,
                const Pose& T_world_local);
  void add_gnss(const GnssSample& sample) { gnss_.add(sample, trajectory_); }
  /// Correction that has become available by t, if any.
  std::optional<Pose> correction(TimeNs t);
  /// Poses of the submaps as of the last available result.
  const SubmapPoses& submap_poses() const { return submap_poses_; }
  /// Trajectory of this flight, submaps, closures and refused closures, in the local frame.
  void append_overlays(std::vector<Overlay>& overlays) const;
  /// Refused closures by reason.
  void append_counters(std::vector<Counter>& counters) const { closer_.append_counters(counters); }
  /// Map of this flight and of the earlier ones. A flight that is not localized in its prior map adds nothing to it.
  std::shared_ptr<const SavedMap> saved_map() const;

  int num_nodes() const { return static_cast<int>(trajectory_.nodes().size()); }
  int num_submaps() const override { return static_cast<int>(trajectory_.submaps().size()); }
  std::span<const Eigen::Vector3f> points_submap_m(int submap) const override {
    return trajectory_.submaps()[static_cast<std::size_t>(submap)].points_submap_m;
  }
  const Pose& T_local_submap(int submap) const override {
    return submap_poses_.T_local_own[static_cast<std::size_t>(submap)];
  }
  double path_length_m(int submap) const override {
    return trajectory_.submaps()[static_cast<std::size_t>(submap)].begin_m;
  }
  std::uint64_t places_revision() const override { return submap_poses_.revision; }
  int num_closures() const { return trajectory_.num_closures(); }
  /// Number of points of all finished submaps, the main part of the memory.
  std::size_t num_points() const;
  /// True when the pose of this flight in its prior map is known.
  bool located() const { return closer_.located(); }
  /// Relocalization has reached its limit of attempts from one place; it resumes when the vehicle moves on.
  bool search_failed() const { return closer_.search_failed(trajectory_); }
  const PoseGraph& graph() const { return trajectory_.graph(); }

 private:
  struct Learned {
    TimeNs begun = 0;
    Pose T_world_local = Pose::Identity();
    std::vector<Pose> T_local_own, T_local_given;  // poses of the submaps at that time
  };

  void begin_next_submap();
  void record_dropped(const SubmapHeir& heir);
  void record_begun();
  void optimize(TimeNs t);

  GlobalSlamConfig config_;
  Latency latency_;
  TrajectoryGraph trajectory_;
  LoopCloser closer_;
  GnssFactors gnss_;
  int num_optimized_closures_ = 0;
  bool has_new_fixes_ = false;  // since the last optimization
  TimeNs last_optimized_ = 0;
  std::vector<Learned> learned_;  // few
  SubmapPoses submap_poses_;
};

}  // namespace swiftlet
