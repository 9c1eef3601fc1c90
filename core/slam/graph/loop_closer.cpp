// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/loop_closer.hpp"

#include <algorithm>
#include <cmath>

#include "core/slam/graph/graph_paths.hpp"
#include "core/slam/level_pose.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// Largest assumed error of a guess [m], also where no factors lead, as to a saved map with a known start. Larger values
// close loops after more drift, and search longer.
constexpr double kMaxGuessError_m = 3.0;
// [-] Largest number of searches of the saved map from one place. Further searches have no new data; larger values only
// take longer.
constexpr int kMaxSearchesFromPlace = 10;
// [m], [s] Flown distance between searches of the saved map for a vehicle of unknown start, and their interval while it
// hovers. Larger values save time and relocalize later.
constexpr double kLocateEvery_m = 4.0, kLocateEvery_s = 1.5;

}  // namespace

/// The nearest older submaps, and their poses in the graph.
std::vector<ClosureCandidate> LoopCloser::candidates_of(const TrajectoryGraph& trajectory,
                                                        std::vector<int>& poses) const {
  const PoseGraph& graph = trajectory.graph();
  const FlightSubmap& newer = trajectory.submaps().back();
  const Pose& T_world_newer = graph.pose(newer.pose);
  struct Near {
    double distance_m = 0.0;
    int pose = 0;
    std::span<const Eigen::Vector3f> points_m;
  };
  std::vector<Near> near;
  const auto consider = [&](int pose, std::span<const Eigen::Vector3f> points_m) {
    const double distance_m = (graph.pose(pose).translation() - T_world_newer.translation()).norm();
    if (distance_m <= config_.closure_distance_m) near.push_back({distance_m, pose, points_m});
  };
  if (config_.loaded_map != nullptr) {
    for (const SavedMap::Submap& given : config_.loaded_map->submaps) consider(given.pose, given.points_submap_m);
  }
  for (const FlightSubmap& older : trajectory.submaps()) {
    if (&older == &newer || older.thinned_out || newer.begin_m - older.end_m < config_.closure_gap_m) continue;
    consider(older.pose, older.points_submap_m);
  }
  std::stable_sort(near.begin(), near.end(), [](const Near& a, const Near& b) { return a.distance_m < b.distance_m; });
  near.resize(std::min<std::size_t>(near.size(), config_.searches));
  const std::vector<double> path_length_m = shortest_path_lengths_m(graph, newer.pose);
  std::vector<ClosureCandidate> candidates;
  for (const Near& older : near) {
    poses.push_back(older.pose);
    ClosureCandidate& candidate = candidates.emplace_back();
    candidate.points_older_m = older.points_m;
    candidate.T_older_newer_guess = level_pose(graph.pose(older.pose)).inverse() * level_pose(T_world_newer);
    candidate.guess_error_m = guess_error_m(path_length_m[static_cast<std::size_t>(older.pose)] + newer.hidden_m);
  }
  return candidates;
}

std::vector<OlderSubmap> LoopCloser::close_loops(TrajectoryGraph& trajectory) {
  std::vector<OlderSubmap> closed_with;
  if (trajectory.num_given_poses() > 0 && !located_) return closed_with;
  const FlightSubmap& newer = trajectory.submaps().back();
  std::vector<int> poses;
  const std::vector<ClosureCandidate> candidates = candidates_of(trajectory, poses);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const ClosureResult result = find_closure({&candidates[i], 1}, newer.points_submap_m, config_.closures);
    loop_counts_.count(result.verdict);
    if (!result.closed()) {
      refused_.emplace_back(poses[i], newer.pose);
      continue;
    }
    trajectory.add_closure(poses[i], result);
    if (result.observed.isIdentity())
      closed_with.push_back({poses[i], candidates[i].points_older_m, result.T_older_newer});
  }
  return closed_with;
}

bool LoopCloser::is_search_due(TimeNs t, double path_length_m, const TrajectoryGraph& trajectory) const {
  return trajectory.num_given_poses() > 0 && !located_ && !search_failed(trajectory) &&
         path_length_m - hovers_at_m_ < config_.node_every_m && to_seconds(t - searched_at_) >= kLocateEvery_s;
}

bool LoopCloser::search_failed(const TrajectoryGraph& trajectory) const {
  return trajectory.num_given_poses() > 0 && !located_ && num_searches_here_ >= kMaxSearchesFromPlace;
}

void LoopCloser::relocalize(TimeNs t, TrajectoryGraph& trajectory) {
  if (located_ || trajectory.num_given_poses() == 0) return;
  const double path_length_m = trajectory.nodes().back().path_length_m;
  const bool moved_on = trajectory.nodes().size() == 1 || path_length_m - searched_at_m_ >= kLocateEvery_m;
  if (!moved_on && !is_search_due(t, path_length_m, trajectory)) return;
  num_searches_here_ = moved_on ? 1 : num_searches_here_ + 1;
  searched_at_ = t;
  hovers_at_m_ = path_length_m;
  if (moved_on) searched_at_m_ = path_length_m;
  const PoseGraph& graph = trajectory.graph();
  const SavedMap& given = *config_.loaded_map;
  std::vector<ClosureCandidate> candidates;
  for (const SavedMap::Submap& submap : given.submaps) {
    candidates.push_back({level_pose(graph.pose(submap.pose)), submap.points_submap_m});
  }
  const FlightSubmap& own = trajectory.submaps().back();
  const ClosureResult result = find_closure(candidates, trajectory.thinned_m(own.points_submap_m), config_.closures);
  relocalization_counts_.count(result.verdict);
  if (!result.closed()) return;
  located_ = true;
  const int older_pose = given.submaps[result.candidate].pose;
  trajectory.move_flight(level_pose(graph.pose(older_pose) * result.T_older_newer) *
                         level_pose(graph.pose(own.pose)).inverse());
  trajectory.add_closure(older_pose, result);
}

void LoopCloser::forget_refused(int first_dropped_pose) {
  std::erase_if(refused_, [&](const auto& pair) { return pair.second >= first_dropped_pose; });
}

void LoopCloser::append_counters(std::vector<Counter>& counters) const {
  loop_counts_.append_counters("searches for loop closures", counters);
  relocalization_counts_.append_counters("searches of the saved map", counters);
}

/// Bound of the drift of local SLAM over a path, by the odometry sigmas of the graph.
double LoopCloser::guess_error_m(double path_length_m) const {
  const double turn_rad_sqrt_m = config_.odometry_attitude_deg_sqrt_m * kRadPerDeg;
  const double error_m = kErrorSigmas * std::sqrt(path_length_m) *
                         (config_.odometry_position_m_sqrt_m + turn_rad_sqrt_m * config_.closure_distance_m);
  return std::min(error_m, kMaxGuessError_m);
}

}  // namespace swiftlet
