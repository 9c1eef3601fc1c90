// SPDX-License-Identifier: BSD-3-Clause
// Failures while one vehicle guides another: each ends in a message before the flight, or in an event and a safe end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using Changes = std::vector<std::pair<std::string, std::string>>;

const std::string kGuide = "vehicles[0].agent.guidance.", kGuided = "vehicles[1].agent.guidance.";

/// Through the gap and back, with true places: nothing is detected, so that the flights are short work.
Scenario guided_gap(const Changes& changes) {
  Changes all = {{"recorders", "[]"},
                 {"snapshots", "[]"},
                 {"duration_s", "90"},
                 {"vehicles[0].agent.detector", "{type: none}"},
                 {"vehicles[0].agent.tracker", "{type: none}"},
                 {"vehicles[0].agent.relative_localization", "{type: shared_world, other: secondary}"},
                 {"vehicles[1].start.known", "pose"},
                 {"vehicles[1].agent.localization", "{type: ground_truth}"},
                 {kGuide + "retries", "1"},
                 {kGuide + "stage_timeout_s", "20"}};
  all.insert(all.end(), changes.begin(), changes.end());
  return load_scenario("guided_gap", all);
}

struct Outcome {
  std::set<std::string> guide_says, guided_says;
  bool guide_crashed = false, guided_crashed = false;
  MissionStatus mission = MissionStatus::kRunning;  // mission of the guide
  double over_s = 1e9;                              // time at which the guide's mission ended
};

Outcome fly_with(const Changes& changes) {
  Simulation simulation(guided_gap(changes));
  Outcome outcome;
  while (!simulation.finished()) {
    simulation.tick();
    for (const Event& event : simulation.view().events) {
      (event.vehicle == 0 ? outcome.guide_says : outcome.guided_says).insert(event.note);
      if (event.vehicle == 0 && event.kind.starts_with("mission_")) outcome.over_s = to_seconds(event.t);
      if (event.kind == "crash") (event.vehicle == 0 ? outcome.guide_crashed : outcome.guided_crashed) = true;
    }
  }
  outcome.mission = simulation.view().actions[0]->mission;
  return outcome;
}

void expect_failure(const Changes& changes, const std::string& reason) {
  const Outcome outcome = fly_with(changes);
  EXPECT_EQ(outcome.mission, MissionStatus::kFailed);
  EXPECT_THAT(outcome.guide_says, Contains(HasSubstr(reason)));
  EXPECT_FALSE(outcome.guide_crashed || outcome.guided_crashed);
  EXPECT_LT(outcome.over_s, 50.0) << "the mission fails within 50 s";
}

void expect_refused(const Changes& changes, const std::string& message) {
  try {
    Simulation simulation(guided_gap(changes));
    FAIL() << message;
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(message));
  }
}

TEST(GuidanceFaultsInFull, ToleratesSlowRadioAndPlanningLatency) {
  for (const char* latency_s : {"0", "1"}) {
    const Outcome outcome = fly_with({{kGuide + "planning_latency_s", latency_s},
                                      {"radio.delay_s", "1"},
                                      {kGuide + "link_timeout_s", "3"},
                                      {kGuided + "link_timeout_s", "3"},
                                      {kGuide + "stage_timeout_s", "60"}});
    EXPECT_EQ(outcome.mission, MissionStatus::kDone) << latency_s;
    EXPECT_FALSE(outcome.guide_crashed || outcome.guided_crashed) << latency_s;
  }
}

TEST(GuidanceFaults, BlindLidarEndsTheMission) {
  expect_failure({{"vehicles[0].sensors[0].range_max_m", "1.2"}}, "unknown space");
}

TEST(GuidanceFaults, UnreachableGoalEndsTheMission) {
  // Two meters beside the gap, 0.2 m before the wall.
  expect_failure({{kGuide + "goals_m", "[[-1.117, 1.686, 1.5]]"}, {kGuide + "planner.goal_search_m", "0.2"}},
                 "the goal is too near to an obstacle");
  expect_failure({{kGuide + "goals_m", "[[300, -200, 1.5]]"}}, "unknown space");
}

TEST(GuidanceFaults, UnknownStartEndsTheMission) {
  // Behind the wall, where the guide has never seen anything.
  expect_failure(
      {{"vehicles[1].start.position_m", "[1.451, 3.987, 1.5]"}, {kGuide + "goals_m", "[[-3.625, -1.690, 1.5]]"}},
      "no clear space around the start");
}

TEST(GuidanceFaults, RefusesNumbersBeyondTheMap) {
  expect_refused({{kGuide + "goals_m", "[[1e18, 0, 1.5]]"}}, "goals_m");
  expect_refused({{kGuide + "planner.secondary.clearance_m", "1e18"}}, "clearance_m");
  expect_refused({{kGuide + "planner.primary.clearance_m", "0"}}, "clearance_m");
}

TEST(GuidanceFaults, RefusesAMissingVehicle) { expect_refused({{kGuide + "secondary", "uav7"}}, "secondary"); }

TEST(GuidanceFaultsInFull, VehicleWithoutOdometryEndsTheMission) {
  expect_failure({{"vehicles[1].agent.guidance", "{type: hover}"}}, "the guided vehicle was not found");
}

TEST(GuidanceFaults, RefusesAVehicleWithoutOdometer) {
  expect_refused({{"vehicles[1].agent.localization", "{type: odometry}"},
                  {"vehicles[1].sensors", "[{type: imu, name: imu, model: imu_mrs}]"}},
                 "localization.type: odometry: expected a sensor of type odometry on secondary, found none");
}

TEST(GuidanceFaultsInFull, SilentRadioEndsTheMission) {
  expect_failure({{"radio.loss_probability", "1"}}, "the guided vehicle was not found");
}

TEST(GuidanceFaults, GuidedVehicleCrashEndsTheMission) {
  // A gap that is narrower than it, and a planner that does not mind.
  const Outcome outcome = fly_with({{"world.gap_width_m", "0.5"}, {kGuide + "planner.secondary.clearance_m", "0.1"}});
  EXPECT_TRUE(outcome.guided_crashed);
  EXPECT_FALSE(outcome.guide_crashed);
  EXPECT_EQ(outcome.mission, MissionStatus::kFailed);
  EXPECT_LT(outcome.over_s, 90.0);
}

}  // namespace
}  // namespace swiftlet::sim
