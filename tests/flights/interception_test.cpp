// SPDX-License-Identifier: BSD-3-Clause
// Interception in the full simulation [Vrba 2025, sec. VI-B]: LiDAR, detector, IMM tracker, map and MPC.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::sim {
namespace {

/// Time of the first true capture and of the first one that the interceptor reports [s]; infinite: none.
struct Interception {
  double true_s = std::numeric_limits<double>::infinity(), reported_s = true_s;
  bool contact = false;
};

Interception fly(std::uint64_t seed) {
  Simulation simulation(
      load_scenario("interception", {{"seed", std::to_string(seed)}, {"recorders", "[]"}, {"snapshots", "[]"}}));
  Interception flight;
  while (!simulation.finished()) {
    simulation.tick();
    for (const Event& event : simulation.view().events) {
      if (event.kind == "capture") flight.true_s = std::min(flight.true_s, to_seconds(event.t));
      if (event.kind == "mission_done") flight.reported_s = std::min(flight.reported_s, to_seconds(event.t));
      flight.contact = flight.contact || event.kind == "crash";
    }
  }
  return flight;
}

// The net meets the target where the LiDAR does not see it, mostly at its rim.
TEST(InterceptionInFull, ReportsItsCapturesWithinASecond) {
  for (const std::uint64_t seed : {9001, 9002, 9003, 9004, 9005}) {
    const Interception flight = fly(seed);
    EXPECT_LT(flight.true_s, 30.0) << seed;
    EXPECT_LT(std::abs(flight.reported_s - flight.true_s), 1.0) << seed;
    EXPECT_FALSE(flight.contact) << seed;
  }
}

}  // namespace
}  // namespace swiftlet::sim
