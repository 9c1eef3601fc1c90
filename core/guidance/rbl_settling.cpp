// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/rbl_settling.hpp"

#include <algorithm>

namespace swiftlet {
namespace {

constexpr double kNearer_m = 0.1;  // what counts as progress

}  // namespace

RblStatus RblSettling::update(const RblGoal& goal, const Vector3& p_local_m, std::span<const Neighbor> neighbors,
                              const OccupancyView* map, TimeNs now) {
  const auto to_goal_m = [&](const Vector3& q_local_m) {
    const Vector3 to_m = goal.p_local_m - q_local_m;
    return goal.planar ? to_m.head<2>().norm() : to_m.norm();
  };
  const double distance_m = to_goal_m(p_local_m);
  if (distance_m < least_m_ - kNearer_m) {
    least_m_ = distance_m;
    since_ = now;
  }
  if (patience_s_ <= 0.0 || to_seconds(now - since_) < patience_s_) return {};
  if (!goal.planar && goal.p_local_m.z() < goal.z_min_m)
    return {MissionStatus::kFailed, "the goal lies below the lowest flight level"};
  if (!goal.planar && goal.p_local_m.z() > goal.z_max_m)
    return {MissionStatus::kFailed, "the goal lies above the highest flight level"};
  if (distance_m > goal.reach_m) return {};
  if (map != nullptr && map->distance_m(goal.p_local_m, goal.encumbrance_m) < goal.encumbrance_m)
    return {MissionStatus::kFailed, "an obstacle is at the goal"};
  const bool taken = std::any_of(neighbors.begin(), neighbors.end(), [&](const Neighbor& neighbor) {
    return to_goal_m(neighbor.position_local_m) < distance_m;
  });
  return taken ? RblStatus{MissionStatus::kDone, "settled near the goal: another vehicle is there"} : RblStatus{};
}

}  // namespace swiftlet
