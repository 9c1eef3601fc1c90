// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_settling.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/guidance/separation/neighbor_memory.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

constexpr double kPatience_s = 5.0;

RblGoal goal_at(const Vector3& p_m) {
  RblGoal goal;
  goal.p_local_m = p_m;
  goal.z_min_m = 1.0;
  goal.z_max_m = 10.0;
  goal.reach_m = 3.5;
  goal.encumbrance_m = 0.5;
  goal.apart_m = 1.1;
  return goal;
}

Neighbor neighbor_at(const Vector3& p_m) {
  Neighbor neighbor;
  neighbor.position_local_m = p_m;
  return neighbor;
}

/// Report of a vehicle after waiting at a place.
RblStatus after_waiting(const RblGoal& goal, const Vector3& p_m, const std::vector<Neighbor>& neighbors = {},
                        const OccupancyView* map = nullptr, double patience_s = kPatience_s) {
  RblSettling settling(patience_s);
  RblStatus status;
  for (int i = 0; i <= 60; ++i) {
    status = settling.update(goal, p_m, neighbors, map, from_seconds(0.1 * i));
    if (i < 49) {
      EXPECT_EQ(status.mission, MissionStatus::kRunning) << "too early";
    }
  }
  return status;
}

TEST(RblSettling, FinishesBesideGoalOccupiedByNeighbor) {
  const RblGoal goal = goal_at({0.0, 0.0, 5.0});
  const RblStatus status = after_waiting(goal, {1.5, 0.0, 5.0}, {neighbor_at({0.1, 0.0, 5.0})});
  EXPECT_EQ(status.mission, MissionStatus::kDone);
  EXPECT_NE(std::string(status.note).find("another vehicle"), std::string::npos);
  // The nearest of all finds no room either when another one is almost as near, and far ones wait behind near ones.
  EXPECT_EQ(after_waiting(goal, {0.6, 0.0, 5.0}, {neighbor_at({-0.7, 0.0, 5.0})}).mission, MissionStatus::kDone);
  const RblStatus behind = after_waiting(goal, {2.5, 0.0, 5.0}, {neighbor_at({1.3, 0.0, 5.0})});
  EXPECT_EQ(behind.mission, MissionStatus::kDone);
  EXPECT_NE(std::string(behind.note).find("nearer"), std::string::npos);
  // Alone, or by far the nearest, it is still under way.
  EXPECT_EQ(after_waiting(goal, {1.5, 0.0, 5.0}).mission, MissionStatus::kRunning);
  EXPECT_EQ(after_waiting(goal, {1.5, 0.0, 5.0}, {neighbor_at({-3.0, 0.0, 5.0})}).mission, MissionStatus::kRunning);
  // Far from the goal too, where it only waits for others to pass.
  EXPECT_EQ(after_waiting(goal, {9.0, 0.0, 5.0}, {neighbor_at({7.5, 0.0, 5.0})}).mission, MissionStatus::kRunning);
}

TEST(RblSettling, KeepsVerdictUntilItGetsNearer) {
  RblSettling settling(kPatience_s);
  const RblGoal goal = goal_at({0.0, 0.0, 5.0});
  const std::vector<Neighbor> there{neighbor_at({0.1, 0.0, 5.0})}, gone{neighbor_at({-3.0, 0.0, 5.0})};
  int i = 0;
  const auto status_at = [&](double x_m, const std::vector<Neighbor>& others) {
    return settling.update(goal, {x_m, 0.0, 5.0}, others, nullptr, from_seconds(0.1 * i++));
  };
  while (i <= 50) status_at(1.5, there);
  // The other one flies off: the vehicle has settled until it flies on itself.
  while (i <= 60) EXPECT_EQ(status_at(1.5, gone).mission, MissionStatus::kDone) << i;
  const std::vector<Neighbor> nearer{neighbor_at({1.2, 0.3, 5.0})};
  EXPECT_NE(std::string(status_at(1.5, nearer).note).find("another vehicle is there"), std::string::npos) << "not anew";
  EXPECT_EQ(status_at(1.35, gone).mission, MissionStatus::kRunning);
  while (i <= 100) EXPECT_EQ(status_at(1.35, gone).mission, MissionStatus::kRunning) << i;
}

TEST(RblSettling, ReportsStallAfterTwiceItsPatience) {
  RblSettling settling(kPatience_s);
  const RblGoal goal = goal_at({0.0, 0.0, 5.0});
  for (int i = 0; i <= 120; ++i) {
    const RblStatus status = settling.update(goal, {9.0, 0.0, 5.0}, {}, nullptr, from_seconds(0.1 * i));
    EXPECT_EQ(status.mission, MissionStatus::kRunning);
    EXPECT_EQ(std::string(status.note).empty(), i < 100) << i;
  }
}

TEST(RblSettling, FailsForUnreachableGoals) {
  EXPECT_EQ(after_waiting(goal_at({0.0, 0.0, -2.0}), {0.0, 0.0, 1.2}).mission, MissionStatus::kFailed);
  EXPECT_EQ(after_waiting(goal_at({0.0, 0.0, 12.0}), {0.0, 0.0, 9.0}).mission, MissionStatus::kFailed);
  const testing::CellListMap map(0.2, {{0.0, 0.0, 5.0}});
  const RblStatus status = after_waiting(goal_at({0.0, 0.0, 5.0}), {1.0, 0.0, 5.0}, {}, &map);
  EXPECT_EQ(status.mission, MissionStatus::kFailed);
  EXPECT_NE(std::string(status.note).find("obstacle"), std::string::npos);
}

TEST(RblSettling, IgnoresHeightsInThePlane) {
  RblGoal goal = goal_at({0.0, 0.0, -2.0});
  goal.planar = true;
  EXPECT_EQ(after_waiting(goal, {2.0, 0.0, 5.0}).mission, MissionStatus::kRunning);
}

TEST(RblSettling, KeepsRunningWhileApproachingGoal) {
  RblSettling settling(kPatience_s);
  const RblGoal goal = goal_at({0.0, 0.0, 5.0});
  const std::vector<Neighbor> others{neighbor_at({0.1, 0.0, 5.0})};
  for (int i = 0; i <= 100; ++i) {
    const Vector3 p_m(3.0 - 0.025 * i, 0.0, 5.0);
    EXPECT_EQ(settling.update(goal, p_m, others, nullptr, from_seconds(0.1 * i)).mission, MissionStatus::kRunning) << i;
  }
}

TEST(RblSettling, IsDisabledAtZeroPatience) {
  const RblStatus status =
      after_waiting(goal_at({0.0, 0.0, 5.0}), {1.5, 0.0, 5.0}, {neighbor_at({0.1, 0.0, 5.0})}, nullptr, 0.0);
  EXPECT_EQ(status.mission, MissionStatus::kRunning);
}

}  // namespace
}  // namespace swiftlet
