// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/submap_memory.hpp"

#include <limits>
#include <utility>
#include <vector>

#include "core/slam/graph/near_points.hpp"

namespace swiftlet {
namespace {

/// Points of the newest submap that older ones do not contain.
std::vector<Eigen::Vector3f> uncovered_m(const FlightSubmap& newest, std::span<const OlderSubmap> older,
                                         double voxel_m) {
  std::vector<NearPoints> known;
  for (const OlderSubmap& o : older) known.emplace_back(voxel_m, o.points_older_m);
  std::vector<Eigen::Vector3f> uncovered_m;
  for (const Eigen::Vector3f& p_m : newest.points_submap_m) {
    bool is_known = false;
    for (std::size_t i = 0; i < older.size() && !is_known; ++i) {
      is_known = known[i].contain(older[i].T_older_newest * p_m.cast<double>());
    }
    if (!is_known) uncovered_m.push_back(p_m);
  }
  return uncovered_m;
}

bool is_covered(const FlightSubmap& newest, std::size_t num_uncovered, double covered_share) {
  const auto num = static_cast<double>(newest.points_submap_m.size());
  return num - static_cast<double>(num_uncovered) >= covered_share * num;
}

}  // namespace

void forget_covered_points(std::span<const OlderSubmap> closed_with, const GlobalSlamConfig& config,
                           TrajectoryGraph& trajectory) {
  if (closed_with.empty() || config.covered_share >= 1.0) return;
  const FlightSubmap& newest = trajectory.submaps().back();
  std::vector<Eigen::Vector3f> fresh_m = uncovered_m(newest, closed_with, config.submap_voxel_m);
  if (is_covered(newest, fresh_m.size(), config.covered_share)) trajectory.keep_of_newest(std::move(fresh_m));
}

std::optional<SubmapHeir> heir_of_newest(std::span<const OlderSubmap> closed_with, const GlobalSlamConfig& config,
                                         const TrajectoryGraph& trajectory) {
  const std::vector<FlightSubmap>& submaps = trajectory.submaps();
  const PoseGraph& graph = trajectory.graph();
  const FlightSubmap& newest = submaps.back();
  if (config.covered_share >= 1.0 || submaps.size() < 2) return std::nullopt;
  if (newest.closed > submaps[submaps.size() - 2].closed) return std::nullopt;
  const Pose T_world_newest = closed_with.empty()
                                  ? graph.pose(newest.pose)
                                  : graph.pose(closed_with.front().pose) * closed_with.front().T_older_newest;
  std::vector<OlderSubmap> here;
  double nearest_m = std::numeric_limits<double>::infinity();
  SubmapHeir heir;
  for (std::size_t i = 0; i + 1 < submaps.size(); ++i) {
    const Pose T_older_newest = graph.pose(submaps[i].pose).inverse() * T_world_newest;
    const double distance_m = T_older_newest.translation().norm();
    if (distance_m > 0.5 * config.submap_m) continue;
    here.push_back({submaps[i].pose, submaps[i].points_submap_m, T_older_newest});
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    heir = {static_cast<int>(i), T_older_newest};
  }
  if (static_cast<int>(here.size()) < config.visits_kept) return std::nullopt;
  const std::size_t num_uncovered = uncovered_m(newest, here, config.submap_voxel_m).size();
  if (!is_covered(newest, num_uncovered, config.covered_share)) return std::nullopt;
  return heir;
}

}  // namespace swiftlet
