// SPDX-License-Identifier: BSD-3-Clause
// Plan for two vehicles [Pritzl 2024, alg. 1]: the next action, or the reason of a failure.
#include "swiftlet/core/planning/team_plan.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "core/planning/guiding_viewpoint.hpp"
#include "swiftlet/core/map/overlaid_occupancy.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using testing::CellListMap;
using Next = TeamPlan::Next;

/// Two rooms, 1.5 m high, with a wall between them at x = 2 m and a gap around y = 0.
CellListMap two_team_rooms(double gap_m) {
  CellListMap map(0.25);
  map.occupy_box({2.0, -6.0, 0.0}, {2.25, -0.5 * gap_m, 1.5});
  map.occupy_box({2.0, 0.5 * gap_m, 0.0}, {2.25, 6.0, 1.5});
  return map;
}

/// Configuration of flight nearly in a plane, so that searches are short.
TeamPlannerConfig flat() {
  TeamPlannerConfig config;
  config.primary.z_min_m = config.secondary.z_min_m = 0.6;
  config.primary.z_max_m = config.secondary.z_max_m = 0.9;
  config.primary.max_expansions = config.secondary.max_expansions = 4000;
  config.secondary.clearance_m = 0.5;
  config.goal_search_m = 0.5;
  return config;
}

const Vector3 kPrimary{-4, -2.5, 0.7};

double nearest_obstacle_m(const OccupancyView& map, const std::vector<PlannedPose>& path) {
  double least_m = 10.0;
  for (const PlannedPose& pose : path) least_m = std::min(least_m, map.distance_m(pose.p_local_m, 10.0));
  return least_m;
}

TEST(TeamPlan, SendsTheSmallVehicleThroughGaps) {
  const CellListMap map = two_team_rooms(1.5);
  const TeamPlan plan = plan_team(map, flat(), kPrimary, {{0, 0, 0.7}, 3.0}, {{4, 0.5, 0.7}, -3.0});
  ASSERT_EQ(plan.next, Next::kMovePrimary) << plan.reason;
  EXPECT_GT(nearest_obstacle_m(map, plan.secondary_path), 0.3);
  EXPECT_LT((plan.secondary_path.front().p_local_m - Vector3(0, 0, 0.7)).norm(), 1e-9);
  EXPECT_LT((plan.secondary_path.back().p_local_m - Vector3(4, 0.5, 0.7)).norm(), 1e-9);
  double whole_m = 0.0, flown_m = 0.0;
  for (std::size_t i = 1; i < plan.secondary_path.size(); ++i) {
    const double leg_m = (plan.secondary_path[i].p_local_m - plan.secondary_path[i - 1].p_local_m).norm();
    EXPECT_LT(leg_m, 0.5 + 1e-9);
    whole_m += leg_m;
  }
  // Evenly along the path, and along the shorter arc of the heading.
  const double turn_rad = 2.0 * std::numbers::pi - 6.0;
  for (std::size_t i = 0; i < plan.secondary_path.size(); ++i) {
    if (i > 0) flown_m += (plan.secondary_path[i].p_local_m - plan.secondary_path[i - 1].p_local_m).norm();
    EXPECT_NEAR(plan.secondary_path[i].yaw_rad, 3.0 + turn_rad * flown_m / whole_m, 1e-9) << i;
  }
  EXPECT_GE(plan.viewpoint.num_visible, 3);
  EXPECT_LT(plan.viewpoint.p_local_m.x(), 2.0) << "the viewpoint lies before the gap, which the primary cannot pass";
  EXPECT_LT((plan.primary_local_m.back() - plan.viewpoint.p_local_m).norm(), 1e-9);
}

TEST(TeamPlan, SeparatesThePathsOfBothVehicles) {
  const CellListMap map(0.25);
  // Each vehicle is in the other's straight path.
  const TeamPlan plan = plan_team(map, flat(), {2, 0, 0.7}, {{0, 0, 0.7}, 0.0}, {{4, 0, 0.7}, 0.0});
  ASSERT_NE(plan.next, Next::kFail) << plan.reason;
  for (const PlannedPose& pose : plan.secondary_path) {
    const Eigen::Array2d off = (pose.p_local_m - Vector3(2, 0, 0.7)).head<2>().cwiseAbs().array();
    EXPECT_TRUE((off > 0.75).any()) << pose.p_local_m.transpose();
  }
}

TEST(TeamPlan, MovesThePrimaryOffTheGoal) {
  const CellListMap map(0.25);
  const PlannedPose secondary{{0, 0, 0.7}, 0.0}, goal{{4, 0, 0.7}, 0.0};
  const TeamPlannerConfig config = flat();
  for (const Vector3& primary_m : {goal.p_local_m, Vector3(4.5, 0.5, 0.7)}) {
    const TeamPlan plan = plan_team(map, config, primary_m, secondary, goal);
    ASSERT_EQ(plan.next, Next::kMovePrimary) << plan.reason;
    EXPECT_EQ(plan.goal_local_m, goal.p_local_m) << "the primary leaves, the goal stays";
    for (const PlannedPose& pose : plan.secondary_path) {
      EXPECT_GT((pose.p_local_m - plan.viewpoint.p_local_m).head<2>().norm(), config.viewpoint.buffer_m - map.edge_m());
    }
  }
  const std::vector<PlannedPose> flying = {{{-2, 0, 0.7}, 0.0}, secondary};
  const TeamPlan both = plan_team(map, config, goal.p_local_m, secondary, goal, {.flying = flying});
  EXPECT_EQ(both.next, Next::kFail) << "no simultaneous flight while the primary blocks the goal";
}

TEST(TeamPlan, KeepsAnOccupiedViewpoint) {
  const CellListMap map = two_team_rooms(1.5);
  const TeamPlannerConfig config = flat();
  const PlannedPose secondary{{0, 0, 0.7}, 0.0}, goal{{4, 0.5, 0.7}, 0.0};
  const TeamPlan first = plan_team(map, config, kPrimary, secondary, goal);
  ASSERT_EQ(first.next, Next::kMovePrimary) << first.reason;
  const TeamPlan second = plan_team(map, config, first.viewpoint.p_local_m, secondary, goal);
  EXPECT_EQ(second.next, Next::kMoveSecondary) << second.reason;
}

TEST(TeamPlan, ReportsAReachedGoal) {
  const CellListMap map(0.25);
  EXPECT_EQ(plan_team(map, flat(), kPrimary, {{0, 0, 0.7}, 0.0}, {{0.2, 0, 0.7}, 0.0}).next, Next::kGoalReached);
}

TEST(TeamPlan, MovesGoalsTooNearToObstacles) {
  const CellListMap map = two_team_rooms(1.5);
  const TeamPlan plan = plan_team(map, flat(), kPrimary, {{-2, 0, 0.7}, 0.0}, {{1.6, 3, 0.7}, 0.0});
  ASSERT_NE(plan.next, Next::kFail) << plan.reason;
  EXPECT_LT((plan.goal_local_m - Vector3(1.6, 3, 0.7)).norm(), 0.5);
  EXPECT_GT((plan.goal_local_m - Vector3(1.6, 3, 0.7)).norm(), 0.01);
}

TEST(TeamPlan, SaysWhyThereIsNone) {
  const CellListMap wall = two_team_rooms(0.0);
  TeamPlannerConfig config = flat();
  const PlannedPose start{{0, 0, 0.7}, 0.0};
  const TeamPlan inside = plan_team(wall, config, kPrimary, start, {{2.1, 4, 0.7}, 0.0});
  EXPECT_EQ(inside.next, Next::kFail);
  EXPECT_EQ(inside.reason, "the guided vehicle's path: the goal is too near to an obstacle");

  CellListMap known = two_team_rooms(1.5);
  known.known_within_m = 5.5;
  const TeamPlan outside = plan_team(known, config, kPrimary, start, {{9, 0, 0.7}, 0.0});
  EXPECT_EQ(outside.reason, "the guided vehicle's path: the goal lies in unknown space");

  config.secondary.max_expansions = 10;
  const TeamPlan given_up = plan_team(wall, config, kPrimary, start, {{4, 0, 0.7}, 0.0});
  EXPECT_EQ(given_up.reason, "the guided vehicle's path: the search for a path was given up");

  config = flat();
  config.primary.clearance_m = 50.0;  // nowhere
  const TeamPlan nowhere = plan_team(wall, config, kPrimary, start, {{-2, 0, 0.7}, 0.0});
  EXPECT_EQ(nowhere.reason, "the viewpoint: nowhere safe is the path in sight");
}

TEST(TeamPlan, ReplacesUnreachableViewpoints) {
  // The goal lies behind the wall and is seen from the east only, but the primary cannot pass the gap.
  CellListMap map = two_team_rooms(1.5);
  map.known_within_m = 5.9;  // no path leads around the wall
  TeamPlannerConfig config = flat();
  config.viewpoint.buffer_m = 1.0;
  const TeamPlan plan = plan_team(map, config, kPrimary, {{1.0, 0, 0.7}, 0.0}, {{3.2, -4.5, 0.7}, 0.0});
  ASSERT_EQ(plan.next, Next::kMovePrimary) << plan.reason;
  EXPECT_LT(plan.viewpoint.p_local_m.x(), 2.0);
  std::vector<Vector3> path_local_m;
  for (const PlannedPose& pose : plan.secondary_path) path_local_m.push_back(pose.p_local_m);
  const GuidingViewpoints all = find_guiding_viewpoints(map, kPrimary, path_local_m, {.buffer_m = 1.0});
  ASSERT_FALSE(all.best_first.empty());
  EXPECT_GT(all.best_first.front().p_local_m.x(), 2.0) << "otherwise this test shows nothing";
  EXPECT_GE(all.best_first.front().num_visible, plan.viewpoint.num_visible);
}

}  // namespace
}  // namespace swiftlet
