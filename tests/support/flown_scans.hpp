// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"

namespace swiftlet::testing {

/// A scan of a flying vehicle, frozen at one pose, and that pose. The scan comes from the scenario's first vehicle.
struct FlownScan {
  std::shared_ptr<const Scan> scan;
  Pose T_world_body;
};

/// Every n-th scan of the first vehicle's first sensor, a LiDAR.
inline std::vector<FlownScan> fly_scans(const std::string& scenario_file, int count, int every = 1) {
  sim::Scenario scenario = sim::load_scenario(std::string(SWIFTLET_SOURCE_DIR) + "/scenarios/" + scenario_file);
  scenario.recorders.clear();
  scenario.snapshots.clear();
  scenario.vehicles.resize(1);
  scenario.vehicles[0].sensors[0].as<sim::LidarConfig>().rolling = false;
  sim::Simulation simulation(sim::validated(scenario), 2);
  std::vector<FlownScan> flown;
  for (int seen = 0; static_cast<int>(flown.size()) < count;) {
    simulation.tick();
    for (const auto& labeled : simulation.view().scans[0]) {
      if (seen++ % every != 0) continue;
      const std::shared_ptr<const Scan> scan(labeled, &labeled->scan);
      flown.push_back({scan, labeled->truth.T_world_lidar.front() * scan->T_body_lidar.inverse()});
    }
  }
  return flown;
}

}  // namespace swiftlet::testing
