// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"

namespace swiftlet::testing {

/// A frozen sweep in a hall, with noise, and its pose.
struct HallScan {
  std::shared_ptr<const sim::LabeledScan> labeled;
  Pose T_world_lidar;
  std::vector<Eigen::Vector3f> points_lidar_m;
};

inline HallScan scan_hall(const Vector3& p_world_m, double yaw_deg) {
  sim::Scenario scenario;
  scenario.world = Module(sim::world_module_types(), "hall");
  scenario.vehicles.resize(1);
  sim::VehicleConfig& vehicle = scenario.vehicles.front();
  vehicle.start.position_m = p_world_m;
  vehicle.start.yaw_deg = yaw_deg;
  Module lidar(sim::sensor_module_types(), "lidar");
  auto& config = lidar.as<sim::LidarConfig>();
  config.rolling = false;
  vehicle.sensors.push_back(lidar);
  sim::Simulation simulation(sim::validated(scenario), 2);
  while (simulation.view().scans.empty() || simulation.view().scans[0].empty()) simulation.tick();
  HallScan scan{simulation.view().scans[0][0], {}, {}};
  scan.T_world_lidar = scan.labeled->truth.T_world_lidar.front();
  for (int i = 0; i < scan.labeled->scan.size(); ++i) {
    if (scan.labeled->scan.hit(i)) scan.points_lidar_m.push_back(scan.labeled->scan.point_lidar(i));
  }
  return scan;
}

}  // namespace swiftlet::testing
