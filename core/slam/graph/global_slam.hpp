// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/slam/graph/block_cholesky.hpp"
#include "core/slam/graph/closure.hpp"
#include "core/slam/graph/correction_blend.hpp"
#include "core/slam/graph/submap_provider.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/overlay.hpp"
#include "swiftlet/core/base/samples.hpp"
#include "swiftlet/core/localization/local_poses.hpp"
#include "swiftlet/core/map/submap_poses.hpp"
#include "swiftlet/core/math/latency.hpp"
#include "swiftlet/core/slam/global_slam_config.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {

/// Estimates the pose of the local frame in the world. Key frames (nodes) and submaps of the local trajectory are poses
/// of a graph, with closures at revisited places and GNSS fixes where available as factors.
///
/// The graph is bounded at one place: visits_kept submaps stay. A further one is dropped when it is finished; only its
/// pose and closures stay, until the next submap is finished.
///
/// With a map of an earlier flight the graph starts with that flight's. With a known start pose, its submaps are
/// closure candidates like the own ones. With an unknown start pose, the vehicle is relocalized in all of them.
class GlobalSlam : public SubmapProvider {
 public:
  /// @param pose_known  false: the start pose is a guess that GNSS may replace
  GlobalSlam(const GlobalSlamConfig& config, bool pose_known);

  /// Adds a scan registered by local SLAM, in order of time.
  /// @param T_world_local  present correction, which places the first node
  void add_scan(TimeNs t, const Pose& T_local_body, std::span<const Eigen::Vector3f> points_body_m,
                const Pose& T_world_local);
  void add_gnss(const GnssSample& sample);
  /// Correction that has become available by t, if any.
  std::optional<Pose> correction(TimeNs t);
  /// Poses of the submaps as of the last available result.
  const SubmapPoses& submap_poses() const { return submap_poses_; }
  /// Trajectory of this flight, submaps and closures, in the local frame.
  void append_overlays(std::vector<Overlay>& overlays) const;
  /// Map of this flight and of the earlier ones. A flight that is not localized in its prior map adds nothing to it.
  std::shared_ptr<const SavedMap> saved_map() const;

  int num_nodes() const { return static_cast<int>(nodes_.size()); }
  int num_submaps() const override { return static_cast<int>(submaps_.size()); }
  std::span<const Eigen::Vector3f> points_submap_m(int submap) const override {
    return submaps_[static_cast<std::size_t>(submap)].points_submap_m;
  }
  const Pose& T_local_submap(int submap) const override {
    return submap_poses_.T_local_own[static_cast<std::size_t>(submap)];
  }
  double path_length_m(int submap) const override { return submaps_[static_cast<std::size_t>(submap)].begin_m; }
  std::uint64_t places_revision() const override { return submap_poses_.revision; }
  int num_closures() const { return num_closures_; }
  /// Number of points of all finished submaps, the main part of the memory.
  std::size_t num_points() const;
  /// True when the pose of this flight in its prior map is known.
  bool located() const { return located_; }
  /// Relocalization has reached its limit of attempts from one place; it resumes when the vehicle moves on.
  bool search_failed() const;
  const PoseGraph& graph() const { return graph_; }

 private:
  struct Node {
    TimeNs t = 0;
    int pose = 0;  // index in the graph
    Pose T_local_body = Pose::Identity();
    double path_length_m = 0.0;
  };
  /// Odometry from an older pose to the start of a submap. Replaces the poses of dropped submaps in between.
  struct Tie {
    int pose = -1;  // index in the graph; -1: none
    Pose T_pose_local = Pose::Identity();
    double path_length_m = 0.0;  // path length of the odometry
  };
  enum class Closed { kNot, kPartly, kFully };  // kPartly: one direction is unconstrained
  struct Submap {
    int pose = 0;        // index in the graph
    int first_pose = 0;  // first pose that is removed together with it
    Pose T_local_submap = Pose::Identity();
    double begin_m = 0.0, end_m = 0.0;  // path length
    std::vector<Eigen::Vector3f> points_submap_m;
    bool thinned_out = false;  // most of its content is in older ones
    Closed closed = Closed::kNot;
    Tie tie;
    double hidden_m = 0.0;  // path length of dropped submaps since the last full closure
  };
  /// An older submap, and the pose of the newest one in it.
  struct Older {
    int pose = 0;  // index in the graph
    std::span<const Eigen::Vector3f> points_older_m;
    Pose T_older_newer = Pose::Identity();
  };
  void begin_submap(const Tie& tie, int first_pose, double hidden_m);
  void begin_next_submap();
  void add_gravity();
  std::vector<Eigen::Vector3f> thinned_m(std::span<const Eigen::Vector3f> points_submap_m) const;
  std::vector<Older> seek_closures();
  std::vector<Eigen::Vector3f> unknown_m(std::span<const Older> older) const;
  bool is_covered(std::size_t num_unknown) const;
  void forget_known(std::span<const Older> joined);
  bool drop_known(std::span<const Older> joined);
  void drop_newest(std::span<const Older> joined);
  void record_dropped(int into, const Pose& T_into_newest);
  bool is_search_due(TimeNs t, double path_length_m) const;
  void locate(TimeNs t);
  void join(int older_pose, int newer_pose, const ClosureResult& closure);
  void place_fixes();
  void fit_start();
  void optimize(TimeNs t);
  Pose T_local_world() const;
  std::vector<Pose> given_poses_local() const;
  double off_m(double path_length_m) const;
  Matrix6 odometry_information(double path_length_m) const;

  GlobalSlamConfig config_;
  Latency latency_;
  bool pose_known_;
  PoseGraph graph_;
  GraphWorkspace graph_workspace_;
  std::vector<Node> nodes_;
  std::vector<Submap> submaps_;      // the last one grows
  std::vector<GnssSample> waiting_;  // fixes newer than the last node
  std::vector<MatchedPosition> matched_;
  bool fitted_ = false;
  int num_given_poses_ = 0;  // poses of the prior map; the first ones in the graph
  bool located_ = false;
  double searched_at_m_ = 0.0;  // path length at the last attempt after moving on
  TimeNs searched_at_ = 0;      // time of the last attempt, also in hover
  double hovers_at_m_ = 0.0;    // path length at the last attempt
  int num_searches_here_ = 0;   // attempts since the vehicle moved on
  int num_closures_ = 0;
  bool news_ = false, fixes_ = false;  // new since the last optimization: a closure, a fix
  TimeNs last_optimized_ = 0;
  struct Learned {
    TimeNs begun = 0;
    Pose T_world_local = Pose::Identity();
    std::vector<Pose> T_local_own, T_local_given;  // poses of the submaps at that time
  };
  std::vector<Learned> learned_;  // few
  SubmapPoses submap_poses_;
};

}  // namespace swiftlet
