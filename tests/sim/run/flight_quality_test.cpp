// SPDX-License-Identifier: BSD-3-Clause
// Flight quality in the full simulation with all effects of the physics: true positions against references.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/agile.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

Scenario scenario_of(const std::string& model, const std::string& duration_s, const std::string& agent) {
  const TemporaryDirectory folder;
  const std::string path = folder.path() / "scenario.yaml";
  write_file(path, "duration_s: " + duration_s + "\nworld: {type: empty}\nvehicles:\n  - {name: uav1, model: " + model +
                       ", start: {position_m: [0, 0, 7]}, agent: {localization: {type: ground_truth}, " + agent +
                       "}}\n");
  return load_scenario(path);
}

class EveryVehicle : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Models, EveryVehicle, testing::Values("t650", "f330", "f450", "x500", "kopterworx"),
                         [](const auto& tested) { return std::string(tested.param); });

// Out of a flight, it comes to rest where it should and stays there.
TEST_P(EveryVehicle, HoversWithinTwoCentimetersAfterFlight) {
  Simulation simulation(
      scenario_of(GetParam(), "40", "guidance: {type: hover, at: point, point_m: [12, -5, 4], yaw_deg: 120}"));
  double farthest_m = 0.0;
  while (!simulation.finished()) {
    simulation.tick();
    if (simulation.now() < from_seconds(20.0)) continue;
    farthest_m = std::max(farthest_m, (simulation.view().states[0].p_world_m - Vector3(12, -5, 4)).norm());
  }
  EXPECT_LT(farthest_m, 0.02);
}

// Vrba 2025, Table IV: at most 8.2 m/s and 4.5 m/s^2, 4 to 10 m high. The trajectory is followed by a second spline of
// our own, so that neither guidance nor the reference governor can make it easier.
TEST_P(EveryVehicle, TracksAgileTrajectoriesWithinThirtyCentimeters) {
  for (const char* seed : {"1", "2"}) {
    Simulation simulation(
        scenario_of(GetParam(), "120",
                    "guidance: {type: agile, seed: " + std::string(seed) + "}, control: {limits: {set: agile}}"));
    AgileConfig config;
    config.seed = std::stoul(seed);
    const StackConfig& stack = simulation.scenario().vehicles[0].agent.as<StackConfig>();
    const MotionLimits limits = stack.control.limits.resolve();
    AgileSpline spline(config, {0, 0, 7}, limits.vertical_speed_mps, limits.vertical_acceleration_mps2);
    double sum_sq = 0.0, fastest_mps = 0.0, hardest_mps2 = 0.0;
    int num_ticks = 0;
    while (!simulation.finished()) {
      simulation.tick();
      spline.advance(simulation.scenario().tick_s);
      const Reference reference = spline.reference();
      const VehicleState& state = simulation.view().states[0];
      sum_sq += (state.p_world_m - reference.position_m).squaredNorm();
      fastest_mps = std::max(fastest_mps, state.v_world_mps.norm());
      hardest_mps2 = std::max(hardest_mps2, reference.acceleration_mps2.norm());
      ++num_ticks;
    }
    EXPECT_LT(std::sqrt(sum_sq / num_ticks), 0.3) << "trajectory " << seed;
    EXPECT_GT(fastest_mps, 7.0) << "trajectory " << seed << " is as agile as that of the table";
    EXPECT_GT(hardest_mps2, 4.0) << "trajectory " << seed;
  }
}

}  // namespace
}  // namespace swiftlet::sim
