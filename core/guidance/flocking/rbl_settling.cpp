// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_settling.hpp"

#include <algorithm>
#include <limits>

namespace swiftlet {
namespace {

/// [m] Shortest progress that resets the patience. Larger values report a slowly approaching vehicle.
constexpr double kSettlingStep_m = 0.1;
/// [settle_s] Time without progress after which a wait without a known reason is reported.
constexpr double kUnexplained = 2.0;

double to_goal_m(const RblGoal& goal, const Vector3& q_local_m) {
  const Vector3 to_m = goal.p_local_m - q_local_m;
  return goal.planar ? to_m.head<2>().norm() : to_m.norm();
}

}  // namespace

RblStatus RblSettling::update(const RblGoal& goal, const Vector3& p_local_m, std::span<const Neighbor> neighbors,
                              const OccupancyView* map, TimeNs now) {
  const double distance_m = to_goal_m(goal, p_local_m);
  if (distance_m < least_m_ - kSettlingStep_m) {
    least_m_ = distance_m;
    since_ = now;
    reported_ = {};
  }
  const double waited_s = to_seconds(now - since_);
  if (patience_s_ <= 0.0 || waited_s < patience_s_) return {};
  const RblStatus status = reason(goal, p_local_m, neighbors, map);
  if (status.mission != MissionStatus::kRunning) {
    if (status.mission != reported_.mission) reported_ = status;
  } else if (reported_.mission == MissionStatus::kRunning && waited_s >= kUnexplained * patience_s_) {
    reported_.note = "no progress toward the goal";
  }
  return reported_;
}

/// Reason why the goal is not reached; kRunning if none is known.
RblStatus RblSettling::reason(const RblGoal& goal, const Vector3& p_local_m, std::span<const Neighbor> neighbors,
                              const OccupancyView* map) {
  if (!goal.planar && goal.p_local_m.z() < goal.z_min_m)
    return {MissionStatus::kFailed, "the goal lies below the lowest flight level"};
  if (!goal.planar && goal.p_local_m.z() > goal.z_max_m)
    return {MissionStatus::kFailed, "the goal lies above the highest flight level"};
  const double distance_m = to_goal_m(goal, p_local_m);
  if (distance_m > goal.reach_m) return {};
  if (map != nullptr && map->distance_m(goal.p_local_m, goal.encumbrance_m) < goal.encumbrance_m)
    return {MissionStatus::kFailed, "an obstacle is at the goal"};
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Neighbor& neighbor : neighbors)
    nearest_m = std::min(nearest_m, to_goal_m(goal, neighbor.position_local_m));
  if (nearest_m < goal.apart_m) return {MissionStatus::kDone, "settled near the goal: another vehicle is there"};
  if (nearest_m < distance_m) return {MissionStatus::kDone, "settled near the goal: other vehicles are nearer"};
  return {};
}

}  // namespace swiftlet
