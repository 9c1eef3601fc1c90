// SPDX-License-Identifier: BSD-3-Clause
// The guide's states [Pritzl 2024, sec. II-A], with a guided vehicle that the test moves along the path that it
// receives.
#include "swiftlet/core/guidance/guide.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/messages/guiding_path.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "tests/core/guidance/guide_support.hpp"

namespace swiftlet {
namespace {

using testing::CellListMap;
using testing::guides_uav2;
using testing::place_at_viewpoint;
using Team = testing::GuideAndGuided;

TEST(Guide, PassesThroughItsStatesToGoal) {
  Team team(guides_uav2({{4, 0, 0.7}}));
  team.run(60.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
  for (const char* note : {"planning", "primary moving", "secondary moving", "goal reached"}) {
    EXPECT_TRUE(team.noted(note)) << note;
  }
  EXPECT_LT((team.guided.position_m - Vector3(4, 0, 0.7)).norm(), 0.3);
}

TEST(Guide, VisitsItsGoalsInOrder) {
  Team team(guides_uav2({{4, 0, 0.7}, {4, 3, 0.7}, {0, 3, 0.7}}));
  team.run(150.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
  for (const Vector3& goal : {Vector3(4, 0, 0.7), Vector3(4, 3, 0.7), Vector3(0, 3, 0.7)}) {
    const auto near = [&](const Vector3& p) { return (p - goal).norm() < 0.3; };
    EXPECT_TRUE(std::any_of(team.flown_local_m.begin(), team.flown_local_m.end(), near)) << goal.transpose();
  }
}

TEST(Guide, SendsPublishedSizeAtFiveHertz) {
  Team team(guides_uav2({{4, 0, 0.7}}));
  team.run(60.0);
  const double seconds = to_seconds(team.observation.t);
  EXPECT_NEAR(static_cast<double>(team.message_sizes.size()), 5.0 * seconds, 3.0);
  for (const std::size_t bytes : team.message_sizes) EXPECT_LE(bytes, 484U) << "[Pritzl 2024, tab. IV]";
}

TEST(Guide, SendsPathOnceWithoutPeriodicGuiding) {
  GuideConfig config = guides_uav2({{4, 0, 0.7}});
  config.periodic = false;
  Team team(config);
  team.run(60.0);
  const auto with_waypoints = [](std::size_t bytes) { return bytes > 70; };
  EXPECT_EQ(std::count_if(team.message_sizes.begin(), team.message_sizes.end(), with_waypoints), 1);
}

TEST(Guide, WaitsUntilPartnerPositionIsKnown) {
  Team team(guides_uav2({{4, 0, 0.7}}));
  team.guided.localized = false;
  team.run(20.0);
  EXPECT_STREQ(team.out.note, "idle: the guided vehicle is not localized yet");
  EXPECT_TRUE(team.message_sizes.empty());
  team.guided.localized = true;
  team.guided.covariance(0, 0) = 1.0;
  team.run(5.0);
  EXPECT_STREQ(team.out.note, "idle: the guided vehicle is not localized yet") << "its place is not sure enough";
  team.guided.covariance(0, 0) = 1e-4;
  team.run(60.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
}

TEST(Guide, HoversWithoutLinkOrPosition) {
  for (const bool link : {true, false}) {
    Team team(guides_uav2({{6, 0, 0.7}}));
    while (!team.noted("secondary moving") || team.guided.position_m.x() < 1.0) team.tick();
    team.hears = !link;
    team.guided.covariance(1, 1) = link ? 1e-4 : 0.5;
    team.run(3.0);
    EXPECT_STREQ(team.out.note, link ? "hovering: link to the guided vehicle lost"
                                     : "hovering: the position of the guided vehicle is too uncertain");
    EXPECT_TRUE(team.guided.path_local_m.empty());
    const Vector3 hovers_m = team.guided.position_m;
    team.run(5.0);
    EXPECT_LT((team.guided.position_m - hovers_m).norm(), 1e-9);
    team.hears = true;
    team.guided.covariance(1, 1) = 1e-4;
    team.run(60.0);
    EXPECT_EQ(team.out.mission, MissionStatus::kDone);
  }
}

TEST(Guide, ReportsFailureForVehicleNeverFound) {
  Team team(guides_uav2({{4, 0, 0.7}}));
  team.guided.localized = false;
  team.run(100.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kFailed);
  EXPECT_STREQ(team.out.note, "the guided vehicle was not found");
}

TEST(Guide, AsksLostVehicleToMoveSafely) {
  CellListMap world(0.25);
  world.occupy_box({1.25, -1, 0}, {1.5, 1, 1.5});
  for (const bool cramped : {false, true}) {
    Team team(guides_uav2({{6, 0, 0.7}}), world, {-4, -3, 0.7}, cramped ? Vector3(0.6, 0, 0.7) : Vector3(0, 0, 0.7));
    while (!team.noted("planning")) team.tick();
    team.guided.localized = false;
    team.run(2.0);
    EXPECT_EQ(team.guided.newest.command, GuidingPath::Command::kGuide) << "no command to move shortly after the loss";
    team.run(3.0);
    EXPECT_EQ(team.guided.newest.command, cramped ? GuidingPath::Command::kGuide : GuidingPath::Command::kMove);
    EXPECT_NEAR(team.guided.newest.radius_m, cramped ? 0.0 : 1.25 - 0.6, 1e-9) << "the body needs room, too";
    team.guided.localized = true;
    team.run(60.0);
    EXPECT_EQ(team.out.mission, MissionStatus::kDone);
    for (int i = 0; i < 3; ++i) team.tick();
    EXPECT_EQ(team.guided.newest.command, GuidingPath::Command::kDone);
  }
}

TEST(Guide, ReportsFailureWhenVehicleHasCrashed) {
  GuideConfig config = guides_uav2({{6, 0, 0.7}});
  config.retries = 1;
  config.stage_timeout_s = 10.0;
  Team team(config);
  while (!team.noted("secondary moving")) team.tick();
  team.guided.stuck = true;
  team.hears = false;
  team.run(100.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kFailed);
  EXPECT_TRUE(team.noted("the guided vehicle was lost before its goal"));
}

TEST(Guide, ReportsFailureWhenVehicleStaysPut) {
  GuideConfig config = guides_uav2({{6, 0, 0.7}});
  config.retries = 0;
  config.stage_timeout_s = 8.0;
  Team team(config);
  team.guided.stuck = true;
  team.run(100.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kFailed);
  EXPECT_STREQ(team.out.note, "the guided vehicle does not reach its goal");
  team.tick();
  team.tick();
  EXPECT_EQ(team.guided.newest.command, GuidingPath::Command::kFailed);
}

TEST(Guide, ReportsFailureForGoalInsideObstacle) {
  CellListMap world(0.25);
  world.occupy_box({3, -1, 0}, {5, 1, 1.5});
  GuideConfig config = guides_uav2({{4, 0, 0.7}});
  config.retries = 2;
  Team team(config, world);
  team.run(60.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kFailed);
  EXPECT_STREQ(team.out.note, "the guided vehicle's path: the goal is too near to an obstacle");
}

TEST(Guide, PlanningTakesItsLatency) {
  GuideConfig config = guides_uav2({{4, 0, 0.7}});
  config.planning_latency_s = 3.0;
  Team slow(config);
  config.planning_latency_s = 0.0;
  Team fast(config);
  while (!slow.noted("primary moving")) slow.tick();
  while (!fast.noted("primary moving")) fast.tick();
  EXPECT_NEAR(to_seconds(slow.observation.t - fast.observation.t), 3.0, 0.15);
}

double seconds_to_the_end(GuideConfig::Motion motion, double& least_m, int& stops) {
  GuideConfig config = guides_uav2({});
  config.advance.step_m = {4, 0, 0};
  config.advance.distance_m = 15.0;
  config.motion = motion;
  Team team(config);
  least_m = 100.0;
  stops = 0;
  bool flew = false;
  while (team.out.mission == MissionStatus::kRunning && to_seconds(team.observation.t) < 200.0) {
    team.tick();
    least_m = std::min(least_m, (team.p_m() - team.guided.position_m).head<2>().norm());
    const bool flies = team.guided.velocity_mps.norm() > 0.1;
    stops += flew && !flies;
    flew = flies;
  }
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
  EXPECT_GT(team.guided.position_m.x(), 14.9);
  return to_seconds(team.observation.t);
}

TEST(Guide, FinishesSoonestTogetherThenPlanningAhead) {
  double least_m = 0.0;
  int stops = 0;
  const double alternate_s = seconds_to_the_end(GuideConfig::Motion::kAlternate, least_m, stops);
  EXPECT_EQ(stops, 4);
  const double ahead_s = seconds_to_the_end(GuideConfig::Motion::kAhead, least_m, stops);
  EXPECT_EQ(stops, 4);
  EXPECT_LT(ahead_s, alternate_s - 3.0);
  const double together_s = seconds_to_the_end(GuideConfig::Motion::kTogether, least_m, stops);
  EXPECT_LE(stops, 2) << "one of them at the end";
  EXPECT_LT(together_s, ahead_s - 3.0);
  EXPECT_GT(least_m, 1.5) << "they keep out of each other's air";
}

TEST(Guide, FliesAroundWallSightedOnRoute) {
  for (const bool in_the_guides_way : {false, true}) {
    Team team(guides_uav2({{4, 0, 0.7}}));
    team.run_until(in_the_guides_way ? "primary moving" : "secondary moving", 20.0);
    for (int i = 0; i < 10; ++i) team.tick();
    if (in_the_guides_way) {
      const Vector3 middle_m = 0.5 * (team.p_m() + team.out.goal.position_m);
      team.discover_around(middle_m);
    } else {
      team.discover({2.0, -1.0, 0.0}, {2.25, 1.0, 1.5});
    }
    team.run(60.0);
    EXPECT_EQ(team.out.mission, MissionStatus::kDone);
    EXPECT_TRUE(team.noted(in_the_guides_way ? "replanning: the path to the viewpoint is blocked"
                                             : "replanning: the path of the guided vehicle is blocked"));
    for (const Vector3& p_m : team.flown_local_m) EXPECT_GT(team.map->distance_m(p_m, 1.0), 0.4) << p_m.transpose();
  }
}

TEST(Guide, ChecksOwnPathWhenFlyingTogether) {
  GuideConfig config = guides_uav2({});
  config.advance.step_m = {4, 0, 0};
  config.advance.distance_m = 11.0;
  config.motion = GuideConfig::Motion::kTogether;
  Team team(config);
  bool appeared = false;
  for (int i = 0; i < static_cast<int>(120.0 / team.dt_s) && team.out.mission == MissionStatus::kRunning; ++i) {
    team.tick();
    const Vector3 way_m = team.out.goal.position_m - team.p_m();
    if (appeared || std::string("secondary moving") != team.out.note || way_m.norm() < 2.0) continue;
    appeared = true;
    const Vector3 ahead_m = team.p_m() + 1.8 * way_m.normalized();
    team.discover_around(ahead_m);
  }
  EXPECT_TRUE(appeared);
  EXPECT_TRUE(team.noted("replanning: the path to the viewpoint is blocked"));
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
}

TEST(Guide, IgnoresObstaclesBehindGuidedVehicle) {
  Team team(guides_uav2({{4, 0, 0.7}}));
  team.run_until("secondary moving", 20.0);
  while (team.guided.position_m.x() < 2.5) team.tick();
  team.discover({0.5, -1.0, 0.0}, {0.75, 1.0, 1.5});
  team.run(30.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
  EXPECT_FALSE(team.noted("replanning: the path of the guided vehicle is blocked"));
}

TEST(Guide, RefusesUnknownVehicle) {
  GuideConfig config = guides_uav2({{4, 0, 0.7}});
  config.secondary = "uav99";
  EXPECT_THROW(Team{config}, std::invalid_argument);
}

TEST(Guide, CountsAbandonedSearchesPerVehicle) {
  CellListMap world(0.25);
  world.occupy_box({-3.0, -6.0, 0.0}, {-2.75, 6.0, 1.5});  // between the guide and the path
  for (const bool own : {true, false}) {
    GuideConfig config = guides_uav2({{4, 0, 0.7}});
    (own ? config.planner.primary : config.planner.secondary).max_expansions = 3;
    config.retries = 1;
    Team team(config, world, {-5, 0, 0.7});
    team.run(30.0);
    EXPECT_EQ(team.out.mission, MissionStatus::kFailed);
    const Counter abandoned = team.counter(own ? "planner.primary.max_expansions" : "planner.secondary.max_expansions");
    EXPECT_EQ(abandoned.count, 2U) << team.out.note;
    EXPECT_EQ(abandoned.of, 2U);
    EXPECT_EQ(team.counter(own ? "planner.secondary.max_expansions" : "planner.primary.max_expansions").count, 0U);
  }
}

TEST(Guide, DropsVisitedWaypointsAndRepeatsNone) {
  Team team(guides_uav2({{4, 0, 0.7}}));
  place_at_viewpoint(team);
  hold_for(team, 1.0);
  const std::vector<GuidingPath> first = sent_paths(team);
  ASSERT_EQ(first.size(), 5U) << "five times a second";
  for (std::size_t i = 1; i < first.size(); ++i) EXPECT_EQ(first[i].path, first[i - 1].path + 1);
  const GuidingPath path = first.back();
  EXPECT_EQ(path.command, GuidingPath::Command::kGuide);
  EXPECT_EQ(path.radius_m, 0.0);
  EXPECT_TRUE(path.has_instant);
  ASSERT_EQ(path.waypoints.size(), 8U) << "4 m in steps of half a meter";
  team.guided.position_m = {0.4, 0, 0.7};
  hold_for(team, 0.4);
  const GuidingPath rest = newest(team);
  ASSERT_EQ(rest.waypoints.size(), 7U);
  // In the level body frame, whose heading is 2 rad.
  EXPECT_NEAR(rest.waypoints[0].p_body_m.x(), 0.6 * std::cos(2.0), 1e-5);
  EXPECT_NEAR(rest.waypoints[0].p_body_m.y(), -0.6 * std::sin(2.0), 1e-5);
  EXPECT_NEAR(rest.waypoints[0].yaw_rad, 0.0, 1e-5) << "the waypoint keeps the heading";
}

TEST(Guide, TakesShorterTurnToGoalHeading) {
  for (const double yaw_deg : {90.0, -170.0}) {
    GuideConfig config = guides_uav2({{4, 0, 0.7}});
    config.goal_yaws_deg = {yaw_deg};
    Team team(config);
    place_at_viewpoint(team);
    hold_for(team, 0.4);
    const GuidingPath path = newest(team);
    ASSERT_GT(path.waypoints.size(), 3U);
    const double whole_rad = std::remainder(yaw_deg * kPi / 180.0 - 2.0, 2.0 * kPi);
    EXPECT_NEAR(path.waypoints.back().yaw_rad, whole_rad, 1e-5);
    EXPECT_NEAR(path.waypoints[3].yaw_rad, 0.5 * whole_rad, 1e-5) << "half of it halfway";
  }
}

TEST(Guide, RepeatsLoopedGoalsIndefinitely) {
  GuideConfig config = guides_uav2({{1, 0, 0.7}, {0, 0, 0.7}});
  config.loop = true;
  config.planning_latency_s = config.settle_s = 0.1;
  Team team(config);
  std::vector<int> visits;
  for (int i = 0; i < 600; ++i) {
    team.tick();
    const double x_m = team.guided.position_m.x();
    const int at = x_m > 0.8 ? 1 : x_m < 0.2 ? 0 : -1;
    if (at >= 0 && (visits.empty() || visits.back() != at)) visits.push_back(at);
    ASSERT_EQ(team.out.mission, MissionStatus::kRunning) << "a looped mission does not end";
  }
  EXPECT_GT(visits.size(), 6U);
}

TEST(Guide, SharesViewAndStopsWithoutLink) {
  GuideConfig config = guides_uav2({{8, 0, 0.7}, {8, 8, 0.7}});
  config.motion = GuideConfig::Motion::kTogether;
  config.planner.viewpoint.ray_max_m = 3.0;
  Team team(config);
  double farthest_m = 0.0;
  for (int i = 0; i < 200 && team.guided.position_m.x() < 5.0; ++i) {
    team.tick();
    if (team.out.note != std::string("secondary moving")) continue;
    for (const Vector3& p_m : team.guided.path_local_m)
      farthest_m = std::max(farthest_m, (p_m - team.p_m()).head<2>().norm());
  }
  // Both have flown a tick since then, by 0.1 m each.
  EXPECT_LT(farthest_m, 1.5 * 3.0 + 0.25);
  EXPECT_GT(farthest_m, 1.5 * 3.0 - 0.75);
  team.hears = false;
  team.run_until("hovering: link to the guided vehicle lost", 3.0);
  const Vector3 held_m = team.out.goal.position_m;
  team.run(1.0);
  EXPECT_EQ(team.out.goal.position_m, held_m);
}

}  // namespace
}  // namespace swiftlet
