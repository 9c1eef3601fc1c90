// SPDX-License-Identifier: BSD-3-Clause
// A guide of several vehicles, which the test moves along the paths that they receive.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "swiftlet/core/guidance/guide.hpp"
#include "swiftlet/core/messages/guiding_path.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "tests/core/guidance/guidance_driver.hpp"
#include "tests/core/guidance/guide_support.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using testing::CellListMap;
using testing::GuidanceDriver;
using testing::GuidedVehicle;

GuideConfig team_guide_config(std::vector<GuidedVehicleConfig> secondaries) {
  GuideConfig config = testing::quick_guide();
  config.secondaries = std::move(secondaries);
  return config;
}

/// A guide and its guided vehicles uav2, uav3 and so on, which fly the received paths without inertia.
struct TeamOfSeveral : GuidanceDriver {
  TeamOfSeveral(const GuideConfig& config, const std::vector<Vector3>& starts_m, CellListMap world = CellListMap(0.25))
      : GuidanceDriver("guide", config, {-4, -3, 0.7}), world_(std::move(world)) {
    map = &world_;
    for (const Vector3& start_m : starts_m) team.emplace_back(static_cast<VehicleId>(team.size() + 1), start_m);
  }

  void tick() {
    relatives.clear();
    for (GuidedVehicle& guided : team) {
      guided.observe(observation.t + from_seconds(dt_s));
      if (guided.localized) relatives.push_back(guided);
    }
    step();
    std::vector<Message> sent;
    outbox.empty_into(sent);
    for (const Message& message : sent) {
      GuidingPath path;
      ASSERT_EQ(read_message(message, path), Reading::kDone);
      team.at(static_cast<std::size_t>(message.to) - 1).receive(path);
    }
    approach();
    int num_moving = 0;
    for (std::size_t i = 0; i < team.size(); ++i) {
      team[i].fly(dt_s);
      if (team[i].path_local_m.empty()) continue;
      ++num_moving;
      if (turns.empty() || turns.back() != i) turns.push_back(i);
    }
    most_moving = std::max(most_moving, num_moving);
    for (std::size_t a = 0; a < team.size(); ++a) {
      least_m = std::min(least_m, (team[a].position_m - p_m()).head<2>().norm());
      for (std::size_t b = 0; b < a; ++b) {
        least_m = std::min(least_m, (team[a].position_m - team[b].position_m).head<2>().norm());
      }
    }
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / dt_s) && out.mission == MissionStatus::kRunning; ++i) tick();
  }
  double far_m(std::size_t i, const Vector3& goal_m) const { return (team[i].position_m - goal_m).norm(); }

  std::vector<GuidedVehicle> team;
  int most_moving = 0;
  std::vector<std::size_t> turns;  // vehicles in the order in which they moved
  double least_m = 100.0;          // horizontal distance between any two vehicles

 private:
  CellListMap world_;
};

TEST(GuideOfSeveral, ReachesGoalsInTurnWithoutConflict) {
  // The goal of the first guided vehicle lies behind the second one.
  TeamOfSeveral team(team_guide_config({{.name = "uav2", .goals_m = {{4, -2, 0.7}, {4, 2, 0.7}}},
                                        {.name = "uav3", .goals_m = {{0, 3, 0.7}}},
                                        {.name = "uav4", .goals_m = {{-1, 5, 0.7}, {3, 6, 0.7}}}}),
                     {{0, -2, 0.7}, {2, -2, 0.7}, {0, 1.5, 0.7}});
  team.run(200.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
  EXPECT_LT(team.far_m(0, {4, 2, 0.7}), 0.3);
  EXPECT_LT(team.far_m(1, {0, 3, 0.7}), 0.3);
  EXPECT_LT(team.far_m(2, {3, 6, 0.7}), 0.3);
  EXPECT_EQ(team.most_moving, 1);
  EXPECT_GT(team.least_m, 1.2) << "guided vehicles keep boxes 1.3 m wide free of others, the guide one of 1.5 m";
  for (int i = 0; i < 3; ++i) team.tick();
  for (const GuidedVehicle& guided : team.team) EXPECT_EQ(guided.newest.command, GuidingPath::Command::kDone);
}

TEST(GuideOfSeveral, WaitsUntilAllVehiclesAreLocalized) {
  TeamOfSeveral team(
      team_guide_config({{.name = "uav2", .goals_m = {{4, -2, 0.7}}}, {.name = "uav3", .goals_m = {{4, 2, 0.7}}}}),
      {{0, -2, 0.7}, {0, 2, 0.7}});
  team.team[1].localized = false;
  team.run(15.0);
  EXPECT_STREQ(team.out.note, "idle: the guided vehicle is not localized yet");
  EXPECT_EQ(team.most_moving, 0);
  team.team[1].localized = true;
  team.run(100.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone);
}

TEST(GuideOfSeveral, RetriesBlockedVehicleAfterTheOthers) {
  // A corridor in which the second vehicle blocks the first.
  CellListMap world(0.25);
  world.occupy_box({-2, 1.25, 0}, {8, 1.5, 1.5});
  world.occupy_box({-2, -1.5, 0}, {8, -1.25, 1.5});
  GuideConfig config =
      team_guide_config({{.name = "uav2", .goals_m = {{3, 0, 0.7}}}, {.name = "uav3", .goals_m = {{6, 0, 0.7}}}});
  config.planner.secondary.clearance_m = 0.6;
  config.planner.viewpoint.buffer_m = 1.0;
  TeamOfSeveral team(config, {{0, 0, 0.7}, {2, 0, 0.7}}, world);
  team.run(200.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone) << team.out.note;
  EXPECT_LT(team.far_m(0, {3, 0, 0.7}), 0.3);
  EXPECT_LT(team.far_m(1, {6, 0, 0.7}), 0.3);
}

GuideConfig with_short_planning(GuideConfig config) {
  config.planning_latency_s = config.settle_s = 0.1;
  return config;
}

TEST(GuideOfSeveral, TakesTurnsInListOrder) {
  TeamOfSeveral team(with_short_planning(team_guide_config({{.name = "uav2", .goals_m = {{1, -4, 0.7}, {2, -4, 0.7}}},
                                                            {.name = "uav3", .goals_m = {{1, 0, 0.7}, {2, 0, 0.7}}},
                                                            {.name = "uav4", .goals_m = {{1, 4, 0.7}, {2, 4, 0.7}}}})),
                     {{0, -4, 0.7}, {0, 0, 0.7}, {0, 4, 0.7}});
  team.run(120.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone) << team.out.note;
  EXPECT_EQ(team.turns, (std::vector<std::size_t>{0, 1, 2, 0, 1, 2}));
}

TEST(GuideOfSeveral, SkipsLostVehiclesUntilRelocalized) {
  TeamOfSeveral team(
      with_short_planning(team_guide_config({{.name = "uav2", .goals_m = {{1, -4, 0.7}, {2, -4, 0.7}, {3, -4, 0.7}}},
                                             {.name = "uav3", .goals_m = {{1, 0, 0.7}}}})),
      {{0, -4, 0.7}, {0, 0, 0.7}});
  team.run(0.5);
  team.team[1].localized = false;
  for (int i = 0; i < 600 && team.far_m(0, {2, -4, 0.7}) > 0.3; ++i) team.tick();
  EXPECT_LT(team.far_m(0, {2, -4, 0.7}), 0.3) << team.out.note;
  EXPECT_EQ(team.turns, (std::vector<std::size_t>{0}));
  team.team[1].localized = true;
  team.run(60.0);
  EXPECT_EQ(team.out.mission, MissionStatus::kDone) << team.out.note;
  EXPECT_EQ(team.turns, (std::vector<std::size_t>{0, 1, 0}));
}

// The radius of the figure requested from a lost vehicle is the distance to its neighbor less twice kFigureClearance_m
// (0.6 m). Below kFigureMin_m (0.3 m) none is requested.
TEST(GuideOfSeveral, MovesLostVehicleClearOfNeighbors) {
  for (const double beside_m : {1.4, 1.6, 2.2}) {
    TeamOfSeveral team(
        team_guide_config({{.name = "uav2", .goals_m = {{6, 1, 0.7}}}, {.name = "uav3", .goals_m = {{6, 5, 0.7}}}}),
        {{1, 1, 0.7}, {1, 1 + beside_m, 0.8}});
    team.run(0.3);
    team.team[0].localized = false;
    team.run(3.4);
    EXPECT_EQ(team.team[0].newest.command, beside_m > 1.5 ? GuidingPath::Command::kMove : GuidingPath::Command::kGuide);
    EXPECT_NEAR(team.team[0].newest.radius_m, beside_m > 1.5 ? beside_m - 1.2 : 0.0, 1e-9);
    EXPECT_EQ(team.team[1].newest.command, GuidingPath::Command::kGuide)
        << "the second vehicle is not commanded to move";
    EXPECT_EQ(team.team[1].newest.radius_m, 0.0);
  }
}

TEST(GuideOfSeveral, RefusesAVehicleListedTwice) {
  const GuideConfig config = team_guide_config({{.name = "uav2"}, {.name = "uav2"}});
  EXPECT_THROW(TeamOfSeveral(config, {{0, 0, 0.7}}), std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet
