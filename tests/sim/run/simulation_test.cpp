// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/simulation.hpp"

#include <gtest/gtest.h>

#include "sim/raycast/ray_scene.hpp"
#include "sim/run/run_directory.hpp"
#include "sim/run/summary.hpp"
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

TEST(Simulation, AFinishedMissionEndsTheRunAsDone) {
  Simulation simulation(scenario_of("duration_s: 60\nworld: {type: empty}\nvehicles:\n" +
                                    vehicle("uav1", "[0, 0, 5]", "{type: waypoints, waypoints_m: [[4, 0, 5]]}")));
  const RunSummary summary = fly(simulation);
  EXPECT_EQ(summary.outcome, "done");
  EXPECT_LT(summary.simulated_s, 20.0);
  EXPECT_NEAR(simulation.view().states[0].p_world_m.x(), 4.0, 0.5);
}

TEST(Simulation, ACrashIsAnEventWithTimePlaceAndPartnerAndTheOutcome) {
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

TEST(Simulation, VehiclesThatStartInsideEachOtherAreRefused) {
  const Scenario scenario = scenario_of("world: {type: empty}\nvehicles:\n" + vehicle("uav1", "[0, 0, 5]", "{type: hover}") +
                                        vehicle("uav2", "[0.1, 0, 5]", "{type: hover}"));
  EXPECT_THROW(Simulation{scenario}, InputError);
}

TEST(Simulation, OverlaysAreAskedForOnlyWhenAPictureIsTaken) {
  Simulation simulation(scenario_of("duration_s: 0.1\nworld: {type: empty}\nvehicles:\n" +
                                    vehicle("uav1", "[0, 0, 5]", "{type: hover}") +
                                    "snapshots: [{name: top, type: top, times_s: [0.05]}]\n"));
  int asked = 0;
  while (!simulation.finished()) {
    simulation.tick();
    asked += simulation.view().observations[0].wants_overlays ? 1 : 0;
  }
  EXPECT_EQ(asked, 1);
}

TEST(Simulation, TheTickAllocatesNothingAfterWarmUp) {
  Scenario scenario = load_scenario(SWIFTLET_SOURCE_DIR "/tests/golden/mixed_team.yaml");
  Simulation simulation(scenario, 2);
  while (simulation.now() < from_seconds(0.5)) simulation.tick();
  const std::uint64_t before = test::num_allocations();
  while (!simulation.finished()) simulation.tick();
  EXPECT_EQ(test::num_allocations() - before, 0U) << "in half a simulated second of four LiDARs, radio and metrics";
}

}  // namespace
}  // namespace swiftlet::sim
