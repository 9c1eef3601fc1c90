// SPDX-License-Identifier: BSD-3-Clause
// Flights on SLAM alone, with everything of the simulator: noise of LiDAR and IMU, rolling sweeps, control on the
// estimate.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
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

/// An X500 with a Mid-360 flies straight to the east.
Scenario eastward(const std::string& world, const std::string& from_m, const std::string& to_m, double duration_s,
                  const std::string& slam_keys = "imu: required") {
  const std::string vehicle =
      "[{name: uav1, model: x500, start: {position_m: " + from_m +
      "}, sensors: [{type: lidar, model: mid360, mount: {position_m: [0, 0, 0.12]}}, {type: imu, model: "
      "imu_adis16448}], agent: {localization: {type: slam, " +
      slam_keys +
      "}, guidance: {type: waypoints, speed_mps: 1.5, waypoints_m: "
      "[" +
      to_m + "]}}}]";
  Scenario scenario =
      load_scenario(std::string(SWIFTLET_SOURCE_DIR) + "/scenarios/campus.yaml",
                    {{"world", world}, {"vehicles", vehicle}, {"recorders", "[]"}, {"snapshots", "[]"}});
  scenario.duration_s = duration_s;
  return validated(scenario);
}

TEST(SlamFlight, PassesAWallSeenFromInside) {
  Simulation simulation(eastward("{type: warehouse, door_width_m: 2.4}", "[15.6, 0, 1.5]", "[45, 0, 1.5]", 12.0), 2);
  while (!simulation.finished()) {
    simulation.tick();
    ASSERT_TRUE(simulation.view().actions[0]->estimate.valid) << to_seconds(simulation.now()) << " s";
  }
  EXPECT_GT(simulation.view().states[0].p_world_m.x(), 30.0) << "10 m before the door";
  EXPECT_LT(simulation.summary().metrics.find("estimate_position_max_m", "uav1")->value, 0.03)
      << "the gate is 0.06 m thick, the wall 0.2 m";
}

TEST(SlamFlight, ReturnsBeforeItIsLost) {
  Simulation simulation(
      eastward("{type: warehouse, door_width_m: 2.4}", "[15.6, 0, 1.5]", "[90, 0, 1.5]", 40.0, "return_sigma_m: 0.06"),
      2);
  double farthest_m = 0.0;
  while (!simulation.finished()) {
    simulation.tick();
    farthest_m = std::max(farthest_m, simulation.view().states[0].p_world_m.x());
  }
  EXPECT_GT(farthest_m, 35.0);
  EXPECT_LT(farthest_m, 60.0) << "the warehouse is out of sight";
  const Action& action = *simulation.view().actions[0];
  EXPECT_TRUE(action.estimate.valid);
  EXPECT_EQ(action.mission_note, "returned: too little to see ahead");
  EXPECT_LT((action.estimate.T_local_body.translation() - simulation.view().states[0].p_world_m).norm(), 0.1);
}

TEST(SlamFlight, IsHonestInABareCorridor) {
  const std::string file = ::testing::TempDir() + "/corridor.obj";
  std::ofstream(file) << "v -30 -1.5 0\nv 30 -1.5 0\nv 30 1.5 0\nv -30 1.5 0\n"
                         "v -30 -1.5 3\nv 30 -1.5 3\nv 30 1.5 3\nv -30 1.5 3\n"
                         "f 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 4 3 7 8\n";
  Simulation simulation(eastward("{type: mesh, file: " + file + "}", "[-20, 0, 1.5]", "[20, 0, 1.5]", 20.0), 2);
  double largest_error_sigma = 0.0;
  while (!simulation.finished()) {
    simulation.tick();
    const StateEstimate& e = simulation.view().actions[0]->estimate;
    const Vector3 p_m = simulation.view().states[0].p_world_m;
    const double sigma_m = std::sqrt(e.covariance(0, 0));
    if (e.valid && sigma_m > 0.0)
      largest_error_sigma =
          std::max(largest_error_sigma, std::abs(e.T_local_body.translation().x() - p_m.x()) / sigma_m);
  }
  EXPECT_LT(largest_error_sigma, 3.0) << "nothing constrains the position along the corridor";
  EXPECT_EQ(simulation.view().actions[0]->mission_note, "position too uncertain");
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
