// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/slam/graph/block_cholesky.hpp"
#include "core/slam/graph/closure.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/slam/global_slam_config.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {

/// Key frame of this flight.
struct TrajectoryNode {
  TimeNs t = 0;
  int pose = 0;  ///< index in the graph
  Pose T_local_body = Pose::Identity();
  double path_length_m = 0.0;
};

/// Odometry from an older pose to the start of a submap. Replaces the poses of dropped submaps in between.
struct SubmapTie {
  int pose = -1;  ///< index in the graph; -1: none
  Pose T_pose_local = Pose::Identity();
  double path_length_m = 0.0;  ///< path length of the odometry
};

/// Submap of this flight; the last one grows.
struct FlightSubmap {
  enum class Closed { kNot, kPartly, kFully };  // kPartly: one direction is unobserved

  int pose = 0;        ///< index in the graph
  int first_pose = 0;  ///< first pose that is removed together with it
  Pose T_local_submap = Pose::Identity();
  double begin_m = 0.0, end_m = 0.0;  ///< path length
  std::vector<Eigen::Vector3f> points_submap_m;
  bool thinned_out = false;  ///< most of its content is in older submaps
  Closed closed = Closed::kNot;
  SubmapTie tie;
  double hidden_m = 0.0;  ///< path length of dropped submaps since the last full closure
};

/// A submap of this flight or of the saved map, and the pose of the newest one in it.
struct OlderSubmap {
  int pose = 0;  ///< index in the graph
  std::span<const Eigen::Vector3f> points_older_m;
  Pose T_older_newest = Pose::Identity();
};

/// Information of a pose with these standard deviations.
Matrix6 pose_information(double position_m, double attitude_rad);

/// Pose graph of a flight: nodes along the local trajectory, submaps, and the factors between them. With a map of an
/// earlier flight the graph starts with the graph of that flight.
class TrajectoryGraph {
 public:
  /// @param pose_known  false: the start pose is a guess
  TrajectoryGraph(const GlobalSlamConfig& config, bool pose_known);

  /// Adds a node, tied to the node before by odometry. The first node is placed by T_world_local.
  void add_node(TimeNs t, const Pose& T_local_body, const Pose& T_world_local);
  /// Adds points of the newest node to the newest submap.
  void insert(const Pose& T_local_body, std::span<const Eigen::Vector3f> points_body_m);
  /// Begins a submap at the newest node.
  void begin_submap(double hidden_m);
  /// Thins the newest submap to one point per voxel.
  void thin_newest() { submaps_.back().points_submap_m = thinned_m(submaps_.back().points_submap_m); }
  /// Replaces the points of the newest submap by the points that older submaps lack.
  void keep_of_newest(std::vector<Eigen::Vector3f> points_submap_m);
  /// Removes the nodes of the newest submap. Its pose and closures stay until the next submap is finished, which begins
  /// at the present node.
  /// @param closed_with  older submaps that fully constrain its pose
  void drop_newest(std::span<const OlderSubmap> closed_with);
  /// Adds a closure between an older submap and the newest one.
  void add_closure(int older_pose, const ClosureResult& closure);
  void add(const PositionFactor& factor) { graph_.add(factor); }
  /// Moves all poses of this flight, and removes the guess of its start.
  void move_flight(const Pose& T_new_old);
  /// Adds the start pose as a guess.
  void add_start_guess();
  GraphReport optimize() { return graph_.optimize({}, workspace_); }

  const PoseGraph& graph() const { return graph_; }
  const std::vector<TrajectoryNode>& nodes() const { return nodes_; }
  const std::vector<FlightSubmap>& submaps() const { return submaps_; }
  int num_closures() const { return num_closures_; }
  /// Number of poses of the saved map; the first ones in the graph.
  int num_given_poses() const { return num_given_poses_; }
  /// One point per voxel. Any frame, the same for all arguments.
  std::vector<Eigen::Vector3f> thinned_m(std::span<const Eigen::Vector3f> points_m) const;
  /// Present transform by the newest submap: the surroundings in view do not move in the local frame.
  Pose T_local_world() const { return submaps_.back().T_local_submap * graph_.pose(submaps_.back().pose).inverse(); }
  /// Poses of the saved map's submaps.
  std::vector<Pose> given_poses_local() const;

 private:
  void begin_submap(const SubmapTie& tie, int first_pose, double hidden_m);
  void add_gravity(const TrajectoryNode& node);
  Matrix6 odometry_information(double path_length_m) const;

  GlobalSlamConfig config_;
  bool pose_known_;
  PoseGraph graph_;
  GraphWorkspace workspace_;
  std::vector<TrajectoryNode> nodes_;
  std::vector<FlightSubmap> submaps_;
  int num_given_poses_ = 0;
  int num_closures_ = 0;
};

}  // namespace swiftlet
