// SPDX-License-Identifier: BSD-3-Clause
// Scans of the simulator in an independent odometry: does it drift as on real scans?
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "swiftlet/sim/run/simulation.hpp"
#include "tests/support/icp_odometry.hpp"
#include "tests/support/path_error.hpp"

namespace swiftlet::sim {
namespace {

using support::absolute_error_m;
using support::IcpOdometry;
using support::SweepTimes;
using Overrides = std::vector<std::pair<std::string, std::string>>;

struct Drift {
  double path_m = 0.0;
  double as_fired_m = 0.0, ignored_m = 0.0, reversed_m = 0.0;  ///< absolute error, by how the sweeps' times are taken
};

/// The first vehicle flies by the truth; its scans go to three odometries. The jerk of the start is left out: without
/// an IMU, a motion that jumps is not predicted.
Drift drift_of(const std::string& file, const Overrides& overrides, double from_s, double until_s) {
  Scenario scenario = load_scenario(std::string(SWIFTLET_SOURCE_DIR) + "/scenarios/" + file, overrides);
  scenario.recorders.clear();
  scenario.snapshots.clear();
  scenario.duration_s = until_s;
  Simulation simulation(validated(scenario), 2);
  IcpOdometry odometries[] = {IcpOdometry(SweepTimes::kAsFired), IcpOdometry(SweepTimes::kIgnored),
                              IcpOdometry(SweepTimes::kReversed)};
  std::vector<Vector3> p_odometry_m[3], p_true_m;
  Drift drift;
  while (!simulation.finished()) {
    simulation.tick();
    if (to_seconds(simulation.now()) < from_s) continue;
    for (const auto& labeled : simulation.view().scans[0]) {
      const std::vector<Pose>& T_world_lidar = labeled->truth.T_world_lidar;
      const Vector3 p_m = T_world_lidar[T_world_lidar.size() / 2].translation();
      if (!p_true_m.empty()) drift.path_m += (p_m - p_true_m.back()).norm();
      p_true_m.push_back(p_m);
      for (int i = 0; i < 3; ++i) p_odometry_m[i].push_back(odometries[i].add(labeled->scan).translation());
    }
  }
  drift.as_fired_m = absolute_error_m(p_odometry_m[0], p_true_m);
  drift.ignored_m = absolute_error_m(p_odometry_m[1], p_true_m);
  drift.reversed_m = absolute_error_m(p_odometry_m[2], p_true_m);
  return drift;
}

TEST(OdometryInFull, KissIcpDriftsCentimetersInAisle) {
  const Drift drift =
      drift_of("warehouse.yaml",
               {{"vehicles[uav1].start.position_m", "[0, 0, 3.6]"},
                {"vehicles[uav1].agent.guidance",
                 "{type: trajectory, shape: lissajous, center_m: [0, 0, 3.6], amplitude_m: [15, 0.4, 0.5], "
                 "frequency_ratio: [1, 2, 3], speed_mps: 4, yaw: fixed}"},
                {"vehicles[uav2].sensors", "[]"}},
               3.0, 14.0);
  EXPECT_GT(drift.path_m, 20.0);
  EXPECT_LT(drift.as_fired_m, 0.02);
  EXPECT_GT(drift.reversed_m, 1.5 * drift.as_fired_m);
}

TEST(OdometryInFull, KissIcpNeedsBeamTimes) {
  const Drift drift = drift_of(
      "hall.yaml",
      {{"vehicles[observer].start.position_m", "[0.2, 0, 2.5]"},
       {"vehicles[observer].agent.guidance", "{type: trajectory, center_m: [-3, 0, 2.5], radius_m: 3.2, speed_mps: 4}"},
       {"vehicles[observer].agent.control.limits.set", "agile"},
       {"vehicles[target].start.position_m", "[4.5, -3.2, 2.5]"},
       {"vehicles[target].agent.guidance", "{type: hover}"}},
      4.0, 16.0);
  EXPECT_GT(drift.path_m, 40.0);
  EXPECT_LT(drift.as_fired_m, 0.06);
  EXPECT_GT(drift.ignored_m, 1.3 * drift.as_fired_m);
  EXPECT_GT(drift.reversed_m, 3.0 * drift.as_fired_m);
}

}  // namespace
}  // namespace swiftlet::sim
