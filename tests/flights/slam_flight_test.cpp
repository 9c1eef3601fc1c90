// SPDX-License-Identifier: BSD-3-Clause
// Flights on SLAM alone, with everything of the simulator: noise of LiDAR and IMU, rolling sweeps, control on the
// estimate.
#include <gtest/gtest.h>

#include <string>

#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::sim {
namespace {

/// On local SLAM alone.
Scenario campus_slam(double duration_s, const std::string& key = "matching", const std::string& value = "surfaces") {
  Scenario scenario = load_scenario(std::string(SWIFTLET_SOURCE_DIR) + "/scenarios/campus_slam.yaml",
                                    {{"recorders", "[]"},
                                     {"snapshots", "[]"},
                                     {"vehicles[0].agent.mapping", "none"},
                                     {"vehicles[0].agent.localization.global.enabled", "false"},
                                     {"vehicles[0].agent.localization." + key, value}});
  scenario.duration_s = duration_s;
  return validated(scenario);
}

TEST(SlamFlight, IsCentimeterExactAroundABuilding) {
  Simulation simulation(campus_slam(20.0), 2);
  double largest_step_m = 0.0;
  Vector3 last_off_m = Vector3::Zero();
  while (!simulation.finished()) {
    simulation.tick();
    const StateEstimate& e = simulation.view().actions[0]->estimate;
    ASSERT_TRUE(e.valid) << to_seconds(simulation.now()) << " s";
    EXPECT_EQ(simulation.view().actions[0]->mission_note, "");
    const Vector3 off_m = e.T_local_body.translation() - simulation.view().states[0].p_world_m;
    if (simulation.now() > 2 * kNsPerSecond) largest_step_m = std::max(largest_step_m, (off_m - last_off_m).norm());
    last_off_m = off_m;
  }
  const RunSummary summary = simulation.summary();
  EXPECT_NE(summary.outcome, "crashed");
  EXPECT_GT(summary.metrics.find("path_length_m", "uav1")->value, 30.0);
  EXPECT_LT(summary.metrics.find("estimate_position_max_m", "uav1")->value, 0.06);
  EXPECT_LT(summary.metrics.find("estimate_velocity_rmse_mps", "uav1")->value, 0.03);
  EXPECT_LT(largest_step_m, 0.02) << "no scan makes control jump";
}

TEST(SlamFlight, FliesWithHalfSecondLatency) {
  Simulation simulation(campus_slam(15.0, "latency_s", "0.5"), 2);
  while (!simulation.finished()) simulation.tick();
  const RunSummary summary = simulation.summary();
  EXPECT_NE(summary.outcome, "crashed");
  EXPECT_GT(summary.metrics.find("path_length_m", "uav1")->value, 20.0);
  EXPECT_LT(summary.metrics.find("estimate_position_max_m", "uav1")->value, 0.2);
}

TEST(SlamFlight, TouchesNothingAsDocumented) {
  Simulation simulation(campus_slam(20.0, "matching", "grid"), 2);
  while (!simulation.finished()) {
    simulation.tick();
    ASSERT_TRUE(simulation.view().actions[0]->estimate.valid) << to_seconds(simulation.now()) << " s";
  }
  const RunSummary summary = simulation.summary();
  EXPECT_NE(summary.outcome, "crashed");
  EXPECT_GT(summary.metrics.find("path_length_m", "uav1")->value, 30.0);
  EXPECT_LT(summary.metrics.find("estimate_position_max_m", "uav1")->value, 1.2) << "rings on the floor drag";
}

TEST(SlamFlight, IsIndependentOfThreadCount) {
  for (const char* matching : {"surfaces", "grid"}) {
    std::uint64_t hashes[2] = {};
    for (int threads : {1, 2}) {
      Simulation simulation(campus_slam(3.0, "matching", matching), threads);
      while (!simulation.finished()) simulation.tick();
      hashes[threads - 1] = simulation.state_hash();
    }
    EXPECT_EQ(hashes[0], hashes[1]) << matching;
  }
}

}  // namespace
}  // namespace swiftlet::sim
