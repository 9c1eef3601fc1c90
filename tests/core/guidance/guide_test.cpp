// SPDX-License-Identifier: BSD-3-Clause
// The guide's states [Pritzl 2024, sec. II-A], with a guided vehicle that the test moves along what it is told.
#include "swiftlet/core/guidance/guide.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "swiftlet/core/messages/guiding_path.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "tests/core/guidance/guidance_driver.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using testing::CellListMap;
using testing::GuidanceDriver;

constexpr VehicleId kSecondary = 1;
constexpr double kPi = 3.14159265358979323846;

GuideConfig guides_uav2(std::vector<Eigen::Vector3d> goals_m) {
  GuideConfig config;
  config.secondary = "uav2";
  config.goals_m = std::move(goals_m);
  config.planner.primary.z_min_m = config.planner.secondary.z_min_m = 0.6;
  config.planner.primary.z_max_m = config.planner.secondary.z_max_m = 0.9;
  config.planner.primary.max_expansions = config.planner.secondary.max_expansions = 4000;
  config.planner.goal_search_m = 0.25;
  config.stage_timeout_s = 30.0;
  return config;
}

/// A guide and a guided vehicle that both fly to their goals at 1 m/s without inertia.
struct Team : GuidanceDriver {
  explicit Team(const GuideConfig& config, CellListMap world = CellListMap(0.25),
                const Vector3& primary_m = {-4, -3, 0.7}, const Vector3& secondary_m = {0, 0, 0.7})
      : GuidanceDriver("guide", config, primary_m), world_(std::move(world)) {
    map = &world_;
    guided.other = kSecondary;
    guided.position_m = secondary_m;
    guided.yaw_rad = 2.0;
    guided.covariance.setIdentity();
    guided.covariance *= 1e-4;
  }

  void tick() {
    guided.t = guided.seen = observation.t + from_seconds(dt_s);
    if (hears) guided.heard = guided.heard_stamp = guided.t;
    if (hears) guided.heard_position_m = guided.position_m;
    guided.heard_yaw_rad = guided.yaw_rad;
    relatives.clear();
    if (localized) relatives.push_back(guided);
    step();
    notes[out.note] = to_seconds(observation.t);
    for (const Message& message : outbox.messages()) take(message);
    std::vector<Message> sent;
    outbox.empty_into(sent);
    estimate.v_local_mps = fly(out.goal.position_m, estimate.T_local_body.translation());
    put(p_m() + dt_s * estimate.v_local_mps);
    guided.velocity_mps =
        told_local_m.empty() || stuck ? Vector3(Vector3::Zero()) : fly(told_local_m.front(), guided.position_m);
    guided.position_m += dt_s * guided.velocity_mps;
    while (told_local_m.size() > 1 && (told_local_m.front() - guided.position_m).norm() < 0.2) {
      told_local_m.erase(told_local_m.begin());
    }
    flown_local_m.push_back(guided.position_m);
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / dt_s) && out.mission != MissionStatus::kDone &&
                    out.mission != MissionStatus::kFailed;
         ++i) {
      tick();
    }
  }
  /// A scan shows what nobody had seen.
  void discover(const Vector3& min_local_m, const Vector3& max_local_m) { world_.occupy_box(min_local_m, max_local_m); }
  void run_until(const std::string& note, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / dt_s) && out.note != note; ++i) tick();
  }
  bool said(const std::string& note) const { return notes.count(note) > 0; }

  RelativeEstimate guided;
  bool hears = true, localized = true, stuck = false;
  std::vector<Vector3> told_local_m, flown_local_m;
  std::vector<std::size_t> told_sizes;
  GuidingPath::Word word = GuidingPath::Word::kGuide;  // the newest
  double radius_m = 0.0;
  std::map<std::string, double> notes;  // when each was said last

 private:
  Vector3 fly(const Vector3& goal_m, const Vector3& from_m) const {
    const Vector3 way = goal_m - from_m;
    return way.norm() < 1.0 * dt_s ? Vector3(way / dt_s) : Vector3(way.normalized());
  }
  void take(const Message& message) {
    EXPECT_EQ(message.to, kSecondary);
    GuidingPath path;
    ASSERT_EQ(read_message(message, path), Reading::kDone);
    told_sizes.push_back(message.size_bytes());
    word = path.word;
    radius_m = path.radius_m;
    told_local_m.clear();
    EXPECT_TRUE(path.waypoints.empty() || path.t == guided.heard_stamp);
    const Eigen::AngleAxisd turn(guided.heard_yaw_rad, Vector3::UnitZ());
    for (const GuidingWaypoint& waypoint : path.waypoints) {
      told_local_m.push_back(guided.heard_position_m + turn * waypoint.p_body_m.cast<double>());
    }
  }

  CellListMap world_;
};

TEST(Guide, GoesThroughItsStatesToTheGoal) {
  Team team(guides_uav2({{4, 0, 0.7}}));
  team.run(60.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
  for (const char* note : {"planning", "primary moving", "secondary moving", "goal reached"}) {
    EXPECT_TRUE(team.said(note)) << note;
  }
  EXPECT_LT((team.guided.position_m - Vector3(4, 0, 0.7)).norm(), 0.3);
}

TEST(Guide, TakesItsGoalsOneAfterTheOther) {
  Team team(guides_uav2({{4, 0, 0.7}, {4, 3, 0.7}, {0, 3, 0.7}}));
  team.run(150.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
  for (const Vector3& goal : {Vector3(4, 0, 0.7), Vector3(4, 3, 0.7), Vector3(0, 3, 0.7)}) {
    const auto near = [&](const Vector3& p) { return (p - goal).norm() < 0.3; };
    EXPECT_TRUE(std::any_of(team.flown_local_m.begin(), team.flown_local_m.end(), near)) << goal.transpose();
  }
}

TEST(Guide, AdvancesStepByStepUntilTheDistanceIsFlown) {
  GuideConfig config = guides_uav2({});
  config.advance.step_m = {4, 0, 0};
  config.advance.distance_m = 11.0;
  Team team(config);
  team.run(200.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
  EXPECT_GT(team.guided.position_m.x(), 10.9);
  EXPECT_LT(team.guided.position_m.x(), 13.0);
}

TEST(Guide, SpeaksFiveTimesASecondAndKeepsThePublishedSize) {
  Team team(guides_uav2({{4, 0, 0.7}}));
  team.run(60.0);
  const double seconds = to_seconds(team.observation.t);
  EXPECT_NEAR(static_cast<double>(team.told_sizes.size()), 5.0 * seconds, 3.0);
  for (const std::size_t bytes : team.told_sizes) EXPECT_LE(bytes, 484U) << "[Pritzl 2024, tab. IV]";
}

TEST(Guide, WithoutPeriodicGuidingThePathIsToldOnce) {
  GuideConfig config = guides_uav2({{4, 0, 0.7}});
  config.periodic = false;
  Team team(config);
  team.run(60.0);
  const auto with_waypoints = [](std::size_t bytes) { return bytes > 70; };
  EXPECT_EQ(std::count_if(team.told_sizes.begin(), team.told_sizes.end(), with_waypoints), 1);
}

TEST(Guide, WaitsUntilItKnowsWhereTheOtherIs) {
  Team team(guides_uav2({{4, 0, 0.7}}));
  team.localized = false;
  team.run(20.0);
  EXPECT_STREQ(team.out.note, "idle: the guided vehicle is not localized yet");
  EXPECT_TRUE(team.told_sizes.empty());
  team.localized = true;
  team.guided.covariance(0, 0) = 1.0;
  team.run(5.0);
  EXPECT_STREQ(team.out.note, "idle: the guided vehicle is not localized yet") << "its place is not sure enough";
  team.guided.covariance(0, 0) = 1e-4;
  team.run(60.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
}

TEST(Guide, HoversWhileTheLinkIsLostAndGoesOn) {
  Team team(guides_uav2({{6, 0, 0.7}}));
  while (!team.said("secondary moving") || team.guided.position_m.x() < 1.0) team.tick();
  team.hears = false;
  for (int i = 0; i < 30; ++i) team.tick();
  EXPECT_STREQ(team.out.note, "hovers: the link to the guided vehicle is lost");
  EXPECT_TRUE(team.told_local_m.empty()) << "it is told to hover";
  const Vector3 hovers_m = team.guided.position_m;
  team.run(5.0);
  EXPECT_LT((team.guided.position_m - hovers_m).norm(), 1e-9);
  team.hears = true;
  team.run(60.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
}

TEST(Guide, HoversWhileThePlaceOfTheOtherIsUnsureAndGoesOn) {
  Team team(guides_uav2({{6, 0, 0.7}}));
  while (!team.said("secondary moving") || team.guided.position_m.x() < 1.0) team.tick();
  team.guided.covariance(1, 1) = 0.5;
  team.run(3.0);
  EXPECT_STREQ(team.out.note, "hovers: the place of the guided vehicle is not sure enough");
  EXPECT_TRUE(team.told_local_m.empty());
  team.guided.covariance(1, 1) = 1e-4;
  team.run(60.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
}

TEST(Guide, AVehicleThatIsNeverFoundEndsTheMissionWithItsReason) {
  Team team(guides_uav2({{4, 0, 0.7}}));
  team.localized = false;
  team.run(100.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kFailed);
  EXPECT_STREQ(team.out.note, "the guided vehicle was not found");
  EXPECT_NEAR(to_seconds(team.observation.t), 30.0, 0.2) << "stage_timeout_s";
}

TEST(Guide, AVehicleOfWhichNothingIsKnownAnyMoreIsAskedToMoveWhereItIsClear) {
  CellListMap world(0.25);
  world.occupy_box({1.25, -1, 0}, {1.5, 1, 1.5});
  for (const bool cramped : {false, true}) {
    Team team(guides_uav2({{6, 0, 0.7}}), world, {-4, -3, 0.7}, cramped ? Vector3(0.6, 0, 0.7) : Vector3(0, 0, 0.7));
    while (!team.said("planning")) team.tick();
    team.localized = false;
    team.run(2.0);
    EXPECT_EQ(team.word, GuidingPath::Word::kGuide) << "it may be found again by itself";
    team.run(3.0);
    EXPECT_EQ(team.word, cramped ? GuidingPath::Word::kGuide : GuidingPath::Word::kMove);
    EXPECT_NEAR(team.radius_m, cramped ? 0.0 : 1.25 - 0.6, 1e-9) << "the body needs room, too";
    team.localized = true;
    team.run(60.0);
    EXPECT_EQ(team.out.mission, MissionStatus::kDone);
    for (int i = 0; i < 3; ++i) team.tick();
    EXPECT_EQ(team.word, GuidingPath::Word::kDone);
  }
}

TEST(Guide, AVehicleThatCrashedEndsTheMissionWithItsReason) {
  GuideConfig config = guides_uav2({{6, 0, 0.7}});
  config.retries = 1;
  config.stage_timeout_s = 10.0;
  Team team(config);
  while (!team.said("secondary moving")) team.tick();
  team.stuck = true;
  team.hears = false;
  team.run(100.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kFailed);
  EXPECT_TRUE(team.said("the guided vehicle was lost on its way"));
}

TEST(Guide, AVehicleThatDoesNotMoveEndsTheMissionWithItsReason) {
  GuideConfig config = guides_uav2({{6, 0, 0.7}});
  config.retries = 0;
  config.stage_timeout_s = 8.0;
  Team team(config);
  team.stuck = true;
  team.run(100.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kFailed);
  EXPECT_STREQ(team.out.note, "the guided vehicle does not reach its goal");
  team.tick();
  team.tick();
  EXPECT_EQ(team.word, GuidingPath::Word::kFailed);
}

TEST(Guide, AGoalInAnObstacleEndsTheMissionWithItsReason) {
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
  while (!slow.said("primary moving")) slow.tick();
  while (!fast.said("primary moving")) fast.tick();
  EXPECT_NEAR(to_seconds(slow.observation.t - fast.observation.t), 3.0, 0.15);
}

TEST(Guide, ShowsItsPlan) {
  Team team(guides_uav2({{4, 0, 0.7}}));
  while (!team.said("secondary moving")) team.tick();
  std::vector<Overlay> overlays;
  team.guidance->append_overlays(overlays);
  ASSERT_EQ(overlays.size(), 5U);
  for (const Overlay& overlay : overlays) EXPECT_FALSE(overlay.positions.empty()) << overlay.name;
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

TEST(Guide, PlanningAheadArrivesSoonerAndFlyingTogetherSoonestWithFewerStops) {
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

TEST(Guide, AWallThatComesIntoSightOnTheWayIsFlownAround) {
  for (const bool in_the_guides_way : {false, true}) {
    Team team(guides_uav2({{4, 0, 0.7}}));
    team.run_until(in_the_guides_way ? "primary moving" : "secondary moving", 20.0);
    for (int i = 0; i < 10; ++i) team.tick();
    if (in_the_guides_way) {
      const Vector3 middle_m = 0.5 * (team.p_m() + team.out.goal.position_m);
      team.discover(middle_m - Vector3(0.25, 0.25, 0.75), middle_m + Vector3(0.25, 0.25, 0.75));
    } else {
      team.discover({2.0, -1.0, 0.0}, {2.25, 1.0, 1.5});
    }
    team.run(60.0);
    EXPECT_EQ(team.out.mission, MissionStatus::kDone);
    EXPECT_TRUE(team.said(in_the_guides_way ? "planning anew: the way to the viewpoint is not clear any more"
                                            : "planning anew: the guided vehicle's path is not clear any more"));
    for (const Vector3& p_m : team.flown_local_m) EXPECT_GT(team.map->distance_m(p_m, 1.0), 0.4) << p_m.transpose();
  }
}

TEST(Guide, FlyingAlongItHoldsItsOwnPathAgainstTheMapToo) {
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
    team.discover(ahead_m - Vector3(0.25, 0.25, 0.75), ahead_m + Vector3(0.25, 0.25, 0.75));
  }
  EXPECT_TRUE(appeared);
  EXPECT_TRUE(team.said("planning anew: the way to the viewpoint is not clear any more"));
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
}

TEST(Guide, WhatAppearsBehindTheGuidedVehicleDisturbsNobody) {
  Team team(guides_uav2({{4, 0, 0.7}}));
  team.run_until("secondary moving", 20.0);
  while (team.guided.position_m.x() < 2.5) team.tick();
  team.discover({0.5, -1.0, 0.0}, {0.75, 1.0, 1.5});
  team.run(30.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
  EXPECT_FALSE(team.said("planning anew: the guided vehicle's path is not clear any more"));
}

TEST(Guide, AVehicleThatIsNotThereIsRefused) {
  GuideConfig config = guides_uav2({{4, 0, 0.7}});
  config.secondary = "uav99";
  EXPECT_THROW(Team{config}, std::invalid_argument);
}

TEST(Guide, SearchesThatAreGivenUpAreCountedByTheVehicleTheyAreFor) {
  GuideConfig config = guides_uav2({{6, 0, 0.7}});
  config.planner.secondary.max_expansions = 5;
  config.retries = 1;
  Team team(config);
  team.run(60.0);
  EXPECT_EQ(team.counter("planner.primary.max_expansions").count, 0U);
  const Counter given_up = team.counter("planner.secondary.max_expansions");
  EXPECT_EQ(given_up.count, 2U) << "once, and one retry";
  EXPECT_EQ(given_up.of, 2U);
}

}  // namespace
}  // namespace swiftlet
