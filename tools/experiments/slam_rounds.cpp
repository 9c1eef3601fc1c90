// SPDX-License-Identifier: BSD-3-Clause
#include "slam_rounds.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "parallel.hpp"

namespace swiftlet::tools {

sim::Scenario round_flight(const DriftWorld& world, const DriftLidar& lidar, bool agile, double way_m,
                           std::uint64_t seed, const std::string& localization) {
  constexpr double kCalm_mps = 2.0;
  const double speed_mps = agile ? world.agile_mps : kCalm_mps;
  std::vector<std::pair<std::string, std::string>> changes = {
      {"snapshots", "[]"},
      {"vehicles[0].model", "x500"},
      {"vehicles[0].start.position_m", world.start_m},
      {"vehicles[0].sensors",
       fmt::format("[{{type: lidar, name: lidar, model: {}, mount: {{position_m: [0, 0, 0.15]}}}}, "
                   "{{type: imu, name: imu, model: imu_adis16448}}]",
                   lidar.model)},
      {"vehicles[0].agent.localization", localization},
      {"vehicles[0].agent.control.limits.set", agile ? "agile" : "medium"},
      {"vehicles[0].agent.guidance",
       fmt::format("{{type: waypoints, speed_mps: {}, loop: true, waypoints_m: {}}}", speed_mps, world.waypoints_m)},
      {"duration_s", fmt::format("{:.1f}", way_m / (agile ? 0.65 : 0.93) / speed_mps)},
  };
  if (*world.more_key != '\0') changes.emplace_back(world.more_key, world.more);
  sim::Scenario scenario = scenario_with(world.scenario, seed, std::move(changes));
  scenario.vehicles.resize(1);
  return sim::validated(std::move(scenario));
}

}  // namespace swiftlet::tools
