// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/run/simulation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/guidance/hover.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

Scenario scenario_of(const std::string& yaml) {
  const TemporaryDirectory folder;
  const std::string path = folder.path() / "scenario.yaml";
  write_file(path, yaml);
  return load_scenario(path);
}

std::string vehicle(const std::string& name, const std::string& position, const std::string& guidance,
                    const std::string& more = {}) {
  return "  - {name: " + name + ", model: x500, start: {position_m: " + position + "}, " + more +
         "agent: {localization: {type: ground_truth}, guidance: " + guidance + "}}\n";
}

RunSummary fly(Simulation& simulation) {
  while (!simulation.finished()) simulation.tick();
  return simulation.summary();
}

TEST(Simulation, TimeIsWholeTicks) {
  Simulation simulation(scenario_of("duration_s: 0.1\nworld: {type: empty}\nvehicles:\n" +
                                    vehicle("uav1", "[0, 0, 5]", "{type: hover}")));
  for (int tick = 1; !simulation.finished(); ++tick) {
    simulation.tick();
    EXPECT_EQ(simulation.now(), tick * 4'000'000);
    EXPECT_EQ(simulation.view().states[0].t, simulation.now());
    EXPECT_EQ(simulation.view().observations[0].t, simulation.now());
  }
  EXPECT_EQ(simulation.now(), 100'000'000);
}

/// Keeps what it is given.
class KeepingRecorder : public Recorder {
 public:
  explicit KeepingRecorder(std::vector<VehicleState>& states) : states_(states) {}
  void begin(const RunInfo&) override {}
  void write(const TickView& tick) override {
    states_.push_back(tick.states[0]);
    EXPECT_EQ(tick.t, tick.states[0].t);
    const Action& action = *tick.actions[0];
    EXPECT_EQ(action.estimate.valid, tick.t > 0);
    EXPECT_EQ(std::isnan(action.reference.position_m.x()), tick.t == 0)
        << "guidance wants nothing before it has stepped";
    EXPECT_EQ(tick.scans[0].size(), tick.t == 100'000'000 ? 1U : 0U);
  }
  std::vector<std::filesystem::path> finish() override { return {}; }

 private:
  std::vector<VehicleState>& states_;
};

TEST(Simulation, StartsRecordersBeforeTheFirstTick) {
  Simulation simulation(scenario_of(
      "duration_s: 0.12\nworld: {type: empty}\nvehicles:\n" +
      vehicle("uav1", "[1, 2, 5]", "{type: hover}", "sensors: [{type: lidar, model: puck_lite}, {type: pose}], ")));
  std::vector<VehicleState> states;
  simulation.attach(std::make_unique<KeepingRecorder>(states), "");
  EXPECT_TRUE(states.empty()) << "a run that is only checked records nothing";
  fly(simulation);
  ASSERT_EQ(states.size(), 31U) << "the start and 30 ticks";
  EXPECT_EQ(states.front().t, 0);
  EXPECT_EQ(states.front().p_world_m, Vector3(1, 2, 5));
  EXPECT_EQ(states.back().t, 120'000'000);
}

TEST(Simulation, RecordsStartPoseAtAnyRate) {
  for (const std::string rate_hz : {"0", "100", "3"}) {
    const TemporaryDirectory folder;
    Simulation simulation(scenario_of("duration_s: 0.1\nstart_time_s: 1700000000\nworld: {type: empty}\nvehicles:\n" +
                                      vehicle("uav1", "[1, 2, 5]", "{type: hover}") +
                                      "recorders: [{type: tum, rate_hz: " + rate_hz + "}]\n"));
    simulation.attach_recorders(folder.path());
    fly(simulation);
    simulation.finish();
    EXPECT_THAT(read_whole_file(folder.path() / "trajectories/uav1.tum"),
                testing::HasSubstr("\n1700000000.000000000 1 2 5 0 0 0 1\n"))
        << rate_hz;
  }
}

TEST(Simulation, EndsWhenTheMissionIsDone) {
  Simulation simulation(scenario_of("duration_s: 60\nworld: {type: empty}\nvehicles:\n" +
                                    vehicle("uav1", "[0, 0, 5]", "{type: waypoints, waypoints_m: [[4, 0, 5]]}")));
  const RunSummary summary = fly(simulation);
  EXPECT_EQ(summary.outcome, "done");
  EXPECT_LT(summary.simulated_s, 20.0);
  EXPECT_NEAR(simulation.view().states[0].p_world_m.x(), 4.0, 0.5);
}

TEST(Simulation, RunsDummiesWithoutAMission) {
  const std::string dummy = "  - {name: rock, model: x500, start: {position_m: [5, 5, 50]}, agent: {type: none}}\n";
  Simulation alone(scenario_of("duration_s: 1.5\nworld: {type: empty}\nvehicles:\n" + dummy));
  alone.tick();
  ASSERT_EQ(alone.view().events.size(), 1U);
  EXPECT_EQ(alone.view().events[0].kind, "mission_done");
  EXPECT_EQ(alone.view().events[0].note, "agent none: no mission");
  EXPECT_NEAR(fly(alone).simulated_s, 1.5, 1e-9);

  // The run does not wait for the dummy: the missions of the others end it.
  Simulation beside(scenario_of("duration_s: 60\nworld: {type: empty}\nmetrics: {stop_on_crash: false}\nvehicles:\n" +
                                dummy + vehicle("uav1", "[0, 0, 5]", "{type: waypoints, waypoints_m: [[1, 0, 5]]}")));
  EXPECT_LT(fly(beside).simulated_s, 20.0);
}

TEST(Simulation, ReachesWaypointsFromAnUnknownStart) {
  for (const std::string known : {"pose", "position", "nothing"}) {
    Simulation simulation(
        scenario_of("duration_s: 60\nworld: {type: empty}\nvehicles:\n  - {start: {position_m: [3, 1, 5], yaw_deg: 70, "
                    "known: " +
                    known + "}, agent: {guidance: {type: waypoints, waypoints_m: [[4, -2, 6]]}}}\n"));
    int corrections = 0;
    while (!simulation.finished()) {
      simulation.tick();
      for (const Event& event : simulation.view().events) corrections += event.kind == "correction";
    }
    EXPECT_EQ(simulation.summary().outcome, "done") << known;
    EXPECT_LT((simulation.view().states[0].p_world_m - Vector3(4, -2, 6)).norm(), 0.6) << known;
    EXPECT_EQ(corrections, known == "pose" ? 0 : 1) << known;
    const Action& action = *simulation.view().actions[0];
    EXPECT_LT((action.reference.position_m - Vector3(4, -2, 6)).norm(), 0.6) << "in the world frame";
  }
}

TEST(Simulation, RefusesWorldMapWithoutKnownPose) {
  const Scenario scenario = scenario_of(
      "world: {type: empty, ground: true}\nvehicles: [{start: {known: position}, agent: {detector: {type: vofod, "
      "prior: {world: true}}}}]\n");
  EXPECT_THAT([&] { Simulation simulation(scenario); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("start.known: expected pose")));
}

TEST(Simulation, RefusesLocalizationWithoutRequiredSensors) {
  const auto scenario = [](const std::string& sensors) {
    return scenario_of("world: {type: empty}\nvehicles: [{name: uav1, start: {position_m: [0, 0, 5]}, sensors: [" +
                       sensors + "], agent: {localization: {type: slam}}}]\n");
  };
  EXPECT_THAT([&] { Simulation simulation(scenario("{type: imu}")); },
              testing::ThrowsMessage<InputError>(
                  testing::HasSubstr("localization.type: slam: expected a sensor of type lidar on uav1, found none")));
  EXPECT_THAT(
      [&] { Simulation simulation(scenario("{type: lidar, model: puck_lite}")); },
      testing::ThrowsMessage<InputError>(testing::HasSubstr("expected a sensor of type imu on uav1, found none")));
  Simulation complete(scenario("{type: lidar, model: puck_lite}, {type: imu}"));
}

TEST(Simulation, RefusesSlamLidarNotOnBoard) {
  const auto scenario = [](const std::string& lidars) {
    return scenario_of(
        "world: {type: empty}\nvehicles: [{name: uav1, start: {position_m: [0, 0, 5]}, sensors: [{type: lidar, name: "
        "puck, model: puck_lite}, {type: imu, name: inertial}], agent: {localization: {type: slam, lidars: [" +
        lidars + "]}}}]\n");
  };
  EXPECT_THAT([&] { Simulation simulation(scenario("pukc")); },
              testing::ThrowsMessage<InputError>(
                  testing::HasSubstr("localization.lidars: expected the name of a sensor of type lidar on uav1, found "
                                     "\"pukc\"; did you mean \"puck\"?")));
  EXPECT_THAT([&] { Simulation simulation(scenario("puck, inertial")); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("found \"inertial\"")));
  Simulation complete(scenario("puck"));
}

TEST(Simulation, ReportsCrashDetailsAndOutcome) {
  // Through the wall of a hall, at full speed.
  Scenario scenario = scenario_of("duration_s: 20\nworld: {type: hall}\nvehicles:\n" +
                                  vehicle("uav1", "[0, 0, 1.5]", "{type: waypoints, waypoints_m: [[200, 0, 1.5]]}"));
  scenario.metrics.stop_on_crash = true;
  Simulation simulation(scenario);
  bool crashed = false;
  while (!simulation.finished()) {
    simulation.tick();
    for (const Event& event : simulation.view().events) {
      if (event.kind != "crash") continue;
      crashed = true;
      EXPECT_EQ(event.vehicle, 0);
      EXPECT_FALSE(event.partner.empty());
      EXPECT_GT(event.t, 0);
      EXPECT_LE(event.t, simulation.now());
      EXPECT_LT((event.p_world_m - simulation.view().states[0].p_world_m).norm(), 1.0);
    }
  }
  EXPECT_TRUE(crashed);
  EXPECT_EQ(simulation.summary().outcome, "crashed");
  EXPECT_LT(simulation.now(), from_seconds(20.0));
}

TEST(Simulation, IgnoresWrecksFallingPastTheirGoal) {
  const auto to_the_middle = [](const std::string& name, const std::string& start) {
    return vehicle(name, start, "{type: waypoints, speed_mps: 3, waypoints_m: [[0, 0, 3]]}");
  };
  Simulation simulation(scenario_of("duration_s: 8\nworld: {type: field}\nvehicles:\n" +
                                    to_the_middle("uav1", "[-5, 0, 3]") + to_the_middle("uav2", "[5, 0, 3]") +
                                    to_the_middle("uav3", "[0, 5, 3]") + to_the_middle("uav4", "[0, -5, 3]")));
  int crashes = 0;
  while (!simulation.finished()) {
    simulation.tick();
    for (const Event& event : simulation.view().events) {
      crashes += event.kind == "crash";
      EXPECT_NE(event.kind, "mission_done");
    }
  }
  EXPECT_EQ(crashes, 4);
  const RunSummary summary = simulation.summary();
  for (const char* name : {"uav1", "uav2", "uav3", "uav4"})
    EXPECT_TRUE(std::isnan(summary.metrics.find("time_to_done_s", name)->value)) << name;
}

/// A hunter, by its guidance, and an intruder that hovers.
Scenario hunt(const std::string& guidance, const std::string& second = {}) {
  const auto hunter = [](const std::string& name, const std::string& position, const std::string& of_it) {
    return "  - {name: " + name + ", model: t650, start: {position_m: " + position +
           "}, agent: {localization: {type: ground_truth}, tracker: {type: ground_truth}, guidance: " + of_it + "}}\n";
  };
  return scenario_of("duration_s: 20\nworld: {type: field}\nvehicles:\n" + hunter("a", "[-9, 0, 11.4]", guidance) +
                     (second.empty() ? "" : hunter("b", "[-9, 9, 12]", second)) +
                     vehicle("intruder", "[0, 0, 10]", "{type: hover}"));
}

struct Hunt {
  double capture_s = -1.0, believed_s = -1.0, end_s = 0.0;
  std::string outcome, partner;
};

Hunt fly_hunt(const Scenario& scenario) {
  Simulation simulation(scenario);
  Hunt hunt;
  while (!simulation.finished()) {
    simulation.tick();
    for (const Event& event : simulation.view().events) {
      if (event.kind == "mission_done" && hunt.believed_s < 0.0) hunt.believed_s = to_seconds(event.t);
      if (event.kind != "capture" || hunt.capture_s >= 0.0) continue;
      hunt.capture_s = to_seconds(event.t);
      hunt.partner = event.partner;
    }
  }
  hunt.end_s = to_seconds(simulation.now());
  hunt.outcome = simulation.summary().outcome;
  return hunt;
}

constexpr const char* kIntercept = "{type: intercept, target: intruder, net: {height_m: 0.5}, captures: 1}";

TEST(Simulation, ReportsCaptureBelievedWithinASecond) {
  for (const char* second : {"", kIntercept}) {
    const Hunt flown = fly_hunt(hunt(kIntercept, second));
    EXPECT_GT(flown.capture_s, 0.0);
    EXPECT_EQ(flown.partner, "intruder");
    EXPECT_EQ(flown.outcome, "done");
    EXPECT_NEAR(flown.believed_s, flown.capture_s, 1.0);
    EXPECT_NEAR(flown.end_s, flown.capture_s + 1.0, 1e-9);
  }
  const Hunt endless = fly_hunt(hunt("{type: intercept, target: intruder, captures: 0}"));
  EXPECT_GT(endless.capture_s, 0.0);
  EXPECT_NEAR(endless.end_s, 20.0, 1e-9);
}

TEST(Simulation, EndsOnAnUnnoticedTrueCapture) {
  // Flies its net over the intruder without knowledge of captures.
  guidance_registry().add({{"drag_net", "of this test", make_module_config<HoverConfig>},
                           make_hover,
                           [](const ModuleConfig&, AgentNeeds& needs) {
                             needs.net = CaptureVolume{{0.0, 0.0, -1.2}, 2.0, 0.5, 4.0};
                             needs.captures = 1;
                           },
                           ""});
  const Hunt flown = fly_hunt(hunt("{type: drag_net, at: point, point_m: [4, 0, 11.4]}"));
  EXPECT_GT(flown.capture_s, 0.0);
  EXPECT_LT(flown.believed_s, 0.0);
  EXPECT_NEAR(flown.end_s, flown.capture_s + 1.0, 1e-9);
  EXPECT_EQ(flown.outcome, "done");
}

TEST(Simulation, RefusesOverlappingStarts) {
  const Scenario scenario =
      scenario_of("world: {type: empty}\nvehicles:\n" + vehicle("uav1", "[0, 0, 5]", "{type: hover}") +
                  vehicle("uav2", "[0.1, 0, 5]", "{type: hover}"));
  EXPECT_THROW(Simulation{scenario}, InputError);
}

// One X500, whose legs are 0.2 m long, in a world; returns the error message, or an empty string.
std::string refusal(const std::string& world, const std::string& start, const std::string& more = {}) {
  try {
    Simulation simulation(scenario_of("world: {type: " + world + "}\n" + more +
                                      "vehicles:\n  - name: uav1\n    start: {" + start + "}\n"));
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(Simulation, RefusesBuriedStartNamingLeastHeight) {
  using testing::HasSubstr;
  const std::string message = refusal("hall", "position_m: [0, 0, 0]");
  EXPECT_THAT(message, HasSubstr("scenario.yaml:4:25: vehicles[0].start.position_m: expected room for uav1, found "));
  EXPECT_THAT(message, HasSubstr("found ground in its place; there is room from z = 0.20 m upwards"));
  EXPECT_EQ(refusal("hall", "position_m: [0, 0, 0.2], flying: false"), "");

  EXPECT_THAT(refusal("field", "position_m: [0, 0, -20]"),
              HasSubstr("found a position below the ground; there is room from z = "));
  EXPECT_THAT(refusal("field", "position_m: [0, 0, 0], above_ground: true"), HasSubstr("upwards (above the ground)"));
  EXPECT_EQ(refusal("field", "position_m: [0, 0, 0.3], above_ground: true"), "");
}

TEST(Simulation, RefusesStartsInsideObstacles) {
  using testing::HasSubstr;
  EXPECT_THAT(refusal("hall", "position_m: [1.5, 0, 2]"), HasSubstr("found wall in its place"));
  EXPECT_THAT(refusal("hall", "position_m: [1.5, 0, 2]", "physics: {contacts: false}\n"), "")
      << "a ghost has room anywhere";
  // Without a key for the start, the message names the vehicle's position.
  EXPECT_THAT(refusal("field", "yaw_deg: 90", "wind: {mean_mps: [0, 0, 0]}\n"), "");
}

TEST(Simulation, RefusesDestinationsInsideObstacles) {
  using testing::HasSubstr;
  const auto to = [](const std::string& guidance) {
    return refusal("hall", "position_m: [0, 0, 2]}\n    agent: {guidance: " + guidance);
  };
  EXPECT_EQ(to("{type: waypoints, waypoints_m: [[0, 1, 2], [1, 0, 2]]}"), "");
  EXPECT_THAT(
      to("{type: waypoints, waypoints_m: [[0, 1, 2], [1.5, 0, 2]]}"),
      HasSubstr("scenario.yaml:5:66: vehicles[0].agent.guidance.waypoints_m[1]: expected room for uav1, found wall "
                "in its place; there is room from z = "));
  EXPECT_THAT(
      to("{type: hover, at: point, point_m: [0, 0, 0]}"),
      HasSubstr("vehicles[0].agent.guidance.point_m: expected room for uav1, found ground in its place; there is "
                "room from z = 0.20 m upwards"));
  EXPECT_EQ(to("{type: hover, at: start, point_m: [0, 0, 0]}"), "") << "point_m is not used with at: start";
  EXPECT_EQ(refusal("hall",
                    "position_m: [0, 0, 2], known: nothing}\n    agent: {guidance: {type: hover, at: point, point_m: "
                    "[1.5, 0, 2]}"),
            "")
      << "its own world lies elsewhere";
  const std::string message = to("{type: hover, at: point, point_m: [1.5, 0, 2]}");
  const std::string z = std::to_string(std::stod(message.substr(message.find("from z = ") + 9)));
  EXPECT_EQ(to("{type: hover, at: point, point_m: [1.5, 0, " + z + "]}"), "") << "there is room at that height";
}

TEST(Simulation, AcceptsTheHeightSuggestedByRefusal) {
  for (const char* world : {"field", "campus", "warehouse"}) {
    const std::string message = refusal(world, "position_m: [9, 3, -20]");
    const std::size_t at = message.find("from z = ");
    ASSERT_NE(at, std::string::npos) << world << ": " << message;
    const std::string z = std::to_string(std::stod(message.substr(at + 9)));
    EXPECT_EQ(refusal(world, "position_m: [9, 3, " + z + "]"), "") << world;
  }
}

TEST(Simulation, RequestsOverlaysOnlyForPictures) {
  Simulation simulation(scenario_of("duration_s: 0.1\nworld: {type: empty}\nvehicles:\n" +
                                    vehicle("uav1", "[0, 0, 5]", "{type: hover}") +
                                    "snapshots: [{name: top, type: top, times_s: [0.05]}]\n"));
  int requests = 0;
  while (!simulation.finished()) {
    simulation.tick();
    requests += simulation.view().observations[0].wants_overlays ? 1 : 0;
  }
  EXPECT_EQ(requests, 1);
}

double seconds_of(const std::string& stage, const std::vector<std::pair<std::string, double>>& times_s) {
  for (const auto& [name, time_s] : times_s) {
    if (name == stage) return time_s;
  }
  ADD_FAILURE() << "no stage " << stage;
  return 0.0;
}

TEST(Simulation, TimesAgentStagesWithoutChangingResults) {
  const Scenario scenario = load_scenario(SWIFTLET_SOURCE_DIR "/tests/golden/guidance.yaml", {{"duration_s", "1.5"}});
  Simulation plain(scenario, 2), timed(scenario, 1);
  timed.time_agents();
  EXPECT_EQ(fly(plain).state_hash, fly(timed).state_hash);
  for (const auto& [stage, time_s] : plain.agent_stage_s()) EXPECT_EQ(time_s, 0.0) << stage << " was not requested";

  double sum_s = 0.0;
  for (const auto& [stage, time_s] : timed.agent_stage_s()) {
    sum_s += time_s;
    const bool none = stage == "detection" || stage == "tracking";  // neither vehicle has one
    EXPECT_EQ(time_s > 0.0, !none) << stage << ": " << time_s << " s";
  }
  // With one thread, the clock of the stage "agents" includes that of each agent.
  const double agents_s = seconds_of("agents", timed.summary().stage_wall_s);
  EXPECT_LT(sum_s, agents_s);
  EXPECT_GT(sum_s, 0.5 * agents_s);
}

TEST(Simulation, AllocatesNothingAfterWarmUp) {
  Scenario scenario = load_scenario(SWIFTLET_SOURCE_DIR "/tests/golden/mixed_team.yaml");
  Simulation simulation(scenario, 2);
  while (simulation.now() < from_seconds(0.5)) simulation.tick();
  const std::uint64_t before = test::num_allocations();
  while (!simulation.finished()) simulation.tick();
  EXPECT_EQ(test::num_allocations() - before, 0U) << "in half a simulated second of four LiDARs, radio and metrics";
}

}  // namespace
}  // namespace swiftlet::sim
