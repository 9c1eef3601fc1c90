// SPDX-License-Identifier: BSD-3-Clause
// Separation under guidance that knows nothing of neighbors: vehicles on a circle fly to the opposite side.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::sim {
namespace {

constexpr int kVehicles = 10;
constexpr double kRadius_m = 8.0, kHeight_m = 8.0, kLowest_m = 2.0, kHighest_m = 14.0;

std::string place_on_circle(double angle_rad) {
  char text[96];
  std::snprintf(text, sizeof text, "[%.3f, %.3f, %.1f]", kRadius_m * std::cos(angle_rad),
                kRadius_m * std::sin(angle_rad), kHeight_m);
  return text;
}

Scenario crossing(std::uint64_t seed) {
  std::vector<std::pair<std::string, std::string>> changes = {{"seed", std::to_string(seed)},
                                                              {"duration_s", "20"},
                                                              {"vehicles[stopped].start.position_m", "[60, 0, 8]"},
                                                              {"vehicles[intruder].agent.guidance", "{type: hover}"}};
  for (int i = 0; i < kVehicles; ++i) {
    // Unequal angles: in a regular polygon all vehicles wait for each other.
    const double angle_rad = 2.0 * kPi * i / kVehicles + 0.1 * std::cos(static_cast<double>(seed) + 3.0 * i);
    const std::string vehicle = "vehicles[uav" + std::to_string(i + 1) + "].";
    changes.emplace_back(vehicle + "start.position_m", place_on_circle(angle_rad));
    changes.emplace_back(vehicle + "agent.guidance",
                         "{type: waypoints, speed_mps: 4, waypoints_m: [" + place_on_circle(angle_rad + kPi) +
                             "], separation: {enabled: true, neighbors: {source: sensor}, z_min_m: 2, z_max_m: 14}}");
  }
  return load_scenario("rbl_safety/circle_10", changes);
}

TEST(SeparationOfWaypoints, KeepsDistanceAndHeights) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Simulation simulation(crossing(seed));
    double lowest_m = std::numeric_limits<double>::infinity(), highest_m = -lowest_m, nearest_m = lowest_m;
    while (!simulation.finished()) {
      simulation.tick();
      const auto& states = simulation.view().states;
      for (int i = 0; i < kVehicles; ++i) {
        lowest_m = std::min(lowest_m, states[i].p_world_m.z());
        highest_m = std::max(highest_m, states[i].p_world_m.z());
        for (int k = 0; k < i; ++k)
          nearest_m = std::min(nearest_m, (states[i].p_world_m - states[k].p_world_m).head<2>().norm() +
                                              std::abs(states[i].p_world_m.z() - states[k].p_world_m.z()));
      }
    }
    EXPECT_GT(lowest_m, kLowest_m - 0.2) << seed;
    EXPECT_LT(highest_m, kHighest_m + 0.2) << seed;
    EXPECT_GT(nearest_m, 0.9) << "two encumbrances and the margin, less twice the control error; seed " << seed;
  }
}

}  // namespace
}  // namespace swiftlet::sim
