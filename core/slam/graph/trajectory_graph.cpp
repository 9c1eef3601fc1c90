// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/trajectory_graph.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/slam/graph/graph_paths.hpp"
#include "core/slam/level_pose.hpp"
#include "core/slam/matching/sweep.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// [m], [deg] Standard deviations of a node in its own submap, of a known start pose, and of an unknown one, whose tilt
// is known by gravity. Larger values let closures and fixes move these poses more.
constexpr double kInSubmap_m = 0.005, kInSubmap_deg = 0.02;
constexpr double kStartSigma_m = 0.01, kStartSigma_deg = 0.1;
constexpr double kGuessSigma_m = 10.0, kGuessSigma_deg = 10.0, kTiltSigma_deg = 0.5;

Matrix6 start_information(bool pose_known) {
  if (pose_known) return pose_information(kStartSigma_m, kStartSigma_deg * kRadPerDeg);
  Matrix6 information = pose_information(kGuessSigma_m, kGuessSigma_deg * kRadPerDeg);
  const double tilt_rad = kTiltSigma_deg * kRadPerDeg;
  information.diagonal().segment<2>(3).setConstant(1.0 / (tilt_rad * tilt_rad));
  return information;
}

}  // namespace

Matrix6 pose_information(double position_m, double attitude_rad) {
  Matrix6 information = Matrix6::Zero();
  information.diagonal().head<3>().setConstant(1.0 / (position_m * position_m));
  information.diagonal().tail<3>().setConstant(1.0 / (attitude_rad * attitude_rad));
  return information;
}

TrajectoryGraph::TrajectoryGraph(const GlobalSlamConfig& config, bool pose_known)
    : config_(config), pose_known_(pose_known) {
  if (config.loaded_map == nullptr) return;
  graph_ = config.loaded_map->graph;
  num_given_poses_ = graph_.num_poses();
}

void TrajectoryGraph::add_node(TimeNs t, const Pose& T_local_body, const Pose& T_world_local) {
  TrajectoryNode node{t, 0, T_local_body, 0.0};
  if (nodes_.empty()) {
    node.pose = graph_.add_pose(T_world_local * T_local_body);
    graph_.add(PriorFactor{node.pose, graph_.pose(node.pose), start_information(pose_known_)});
  } else {
    const TrajectoryNode& last = nodes_.back();
    const Pose T_last_node = last.T_local_body.inverse() * T_local_body;
    const double step_m = (T_local_body.translation() - last.T_local_body.translation()).norm();
    node.path_length_m = last.path_length_m + step_m;
    node.pose = graph_.add_pose(graph_.pose(last.pose) * T_last_node);
    graph_.add(RelativeFactor{last.pose, node.pose, T_last_node, odometry_information(step_m), kNoHuber});
  }
  nodes_.push_back(node);
  add_gravity(node);
}

void TrajectoryGraph::insert(const Pose& T_local_body, std::span<const Eigen::Vector3f> points_body_m) {
  FlightSubmap& submap = submaps_.back();
  submap.end_m = nodes_.back().path_length_m;
  const Pose T_submap_body = submap.T_local_submap.inverse() * T_local_body;
  submap.points_submap_m.reserve(submap.points_submap_m.size() + points_body_m.size());
  for (const Eigen::Vector3f& p : points_body_m) {
    submap.points_submap_m.push_back((T_submap_body * p.cast<double>()).cast<float>());
  }
  graph_.add(RelativeFactor{submap.pose, nodes_.back().pose, T_submap_body,
                            pose_information(kInSubmap_m, kInSubmap_deg * kRadPerDeg), kNoHuber});
}

void TrajectoryGraph::add_gravity(const TrajectoryNode& node) {
  graph_.add(GravityFactor{node.pose, node.T_local_body.linear().transpose() * Vector3::UnitZ(),
                           config_.gravity_sigma_deg * kRadPerDeg});
}

void TrajectoryGraph::begin_submap(double hidden_m) {
  const TrajectoryNode& node = nodes_.back();
  SubmapTie tie;
  if (nodes_.size() > 1) {
    const TrajectoryNode& before = nodes_[nodes_.size() - 2];
    tie = {before.pose, before.T_local_body.inverse(), node.path_length_m - before.path_length_m};
  }
  begin_submap(tie, node.pose, hidden_m);
}

void TrajectoryGraph::begin_submap(const SubmapTie& tie, int first_pose, double hidden_m) {
  const TrajectoryNode& node = nodes_.back();
  FlightSubmap submap;
  submap.T_local_submap = level_pose(node.T_local_body);
  submap.begin_m = submap.end_m = node.path_length_m;
  submap.pose = graph_.add_pose(graph_.pose(node.pose) * node.T_local_body.inverse() * submap.T_local_submap);
  submap.first_pose = first_pose;
  submap.tie = tie;
  submap.hidden_m = hidden_m;
  submaps_.push_back(std::move(submap));
}

void TrajectoryGraph::keep_of_newest(std::vector<Eigen::Vector3f> points_submap_m) {
  points_submap_m.shrink_to_fit();
  submaps_.back().points_submap_m = std::move(points_submap_m);
  submaps_.back().thinned_out = true;
}

void TrajectoryGraph::drop_newest(std::span<const OlderSubmap> closed_with) {
  const FlightSubmap dropped = std::move(submaps_.back());
  submaps_.pop_back();
  TrajectoryNode node = nodes_.back();  // first node of the next submap
  const Pose T_world_dropped = graph_.pose(dropped.pose), T_world_node = graph_.pose(node.pose);
  std::vector<RelativeFactor> closures;
  for (const RelativeFactor& f : graph_.relative_factors()) {
    if (f.to == dropped.pose && f.from < dropped.first_pose) closures.push_back(f);
  }
  graph_.truncate(dropped.first_pose);
  std::erase_if(nodes_, [&](const TrajectoryNode& n) { return n.pose >= dropped.first_pose; });
  const int pose = graph_.add_pose(T_world_dropped);
  graph_.add(RelativeFactor{dropped.tie.pose, pose, dropped.tie.T_pose_local * dropped.T_local_submap,
                            odometry_information(dropped.tie.path_length_m), kNoHuber});
  for (RelativeFactor& closure : closures) {
    closure.to = pose;
    graph_.add(closure);
  }
  const double path_length_m = node.path_length_m - dropped.begin_m;
  node.pose = graph_.add_pose(T_world_node);
  graph_.add(RelativeFactor{pose, node.pose, dropped.T_local_submap.inverse() * node.T_local_body,
                            odometry_information(path_length_m), kNoHuber});
  nodes_.push_back(node);
  add_gravity(node);
  if (closed_with.empty()) {
    const SubmapTie& tie = dropped.tie;
    begin_submap({tie.pose, tie.T_pose_local, tie.path_length_m + path_length_m}, pose,
                 dropped.hidden_m + path_length_m);
  } else {
    const OlderSubmap& older = closed_with.front();
    begin_submap({older.pose, older.T_older_newest * dropped.T_local_submap.inverse(), path_length_m}, pose, 0.0);
  }
}

void TrajectoryGraph::add_closure(int older_pose, const ClosureResult& closure) {
  const Matrix6 information = pose_information(config_.closure_position_m, config_.closure_attitude_deg * kRadPerDeg);
  FlightSubmap& newest = submaps_.back();
  graph_.add(RelativeFactor{older_pose, newest.pose, closure.T_older_newer,
                            closure.observed.transpose() * information * closure.observed, config_.closure_huber});
  using Closed = FlightSubmap::Closed;
  newest.closed = std::max(newest.closed, closure.observed.isIdentity() ? Closed::kFully : Closed::kPartly);
  ++num_closures_;
}

void TrajectoryGraph::move_flight(const Pose& T_new_old) {
  for (int i = num_given_poses_; i < graph_.num_poses(); ++i) graph_.set_pose(i, T_new_old * graph_.pose(i));
  graph_.clear_priors(num_given_poses_);
}

void TrajectoryGraph::add_start_guess() {
  const int pose = nodes_.front().pose;
  graph_.add(PriorFactor{pose, graph_.pose(pose), start_information(false)});
}

std::vector<Eigen::Vector3f> TrajectoryGraph::thinned_m(std::span<const Eigen::Vector3f> points_m) const {
  std::vector<std::uint32_t> kept;
  kept.reserve(points_m.size());
  VoxelThinner().thin(points_m, static_cast<float>(config_.submap_voxel_m), kept);
  std::vector<Eigen::Vector3f> thinned_m(kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) thinned_m[i] = points_m[kept[i]];
  return thinned_m;
}

std::vector<Pose> TrajectoryGraph::given_poses_local() const {
  std::vector<Pose> T_local_given;
  if (config_.loaded_map == nullptr) return T_local_given;
  const Pose T_local_from_world = T_local_world();
  for (const SavedMap::Submap& submap : config_.loaded_map->submaps) {
    T_local_given.push_back(T_local_from_world * graph_.pose(submap.pose));
  }
  return T_local_given;
}

Matrix6 TrajectoryGraph::odometry_information(double path_length_m) const {
  const double root = std::sqrt(std::max(path_length_m, kMinPathLength_m));
  return pose_information(config_.odometry_position_m_sqrt_m * root,
                          config_.odometry_attitude_deg_sqrt_m * kRadPerDeg * root);
}

}  // namespace swiftlet
