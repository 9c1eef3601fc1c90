// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "crossing.hpp"
#include "experiments.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/flocking.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/stages/guidances.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kForestEdge_m = 34.0;  // start and goal beyond the trees

struct Method {
  const char* name;
  const char* guidance;
  int informed_every = 1;  // PACNav only; 2: every second vehicle knows the goal
};
constexpr Method kMethods[] = {{"rbl", "rbl"},
                               {"PACNav, all informed", "pacnav"},
                               {"PACNav, every second informed", "pacnav", 2},
                               {"vision-based", "mezey"}};

void choose(sim::VehicleConfig& vehicle, const Method& method) {
  Module& module = vehicle.agent.as<StackConfig>().guidance;
  if (module.type != method.guidance) module = Module(guidance_module_types(), method.guidance);
}

void inform(sim::Scenario& scenario, const Method& method) {
  if (std::string(method.guidance) != "pacnav") return;
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    scenario.vehicles[i].agent.as<StackConfig>().guidance.as<PacnavConfig>().informed =
        i % static_cast<std::size_t>(method.informed_every) == 0;
  }
}

sim::Scenario circle(const Method& method, int n, std::uint64_t seed) {
  sim::Scenario pattern =
      scenario_with("reproduce/rbl_crossing.yaml", seed, {{"vehicles[0].sensors[0].ideal", "true"}});
  choose(pattern.vehicles.front(), method);
  sim::Scenario scenario = make_crossing(pattern, {false, n, 10.0}, 5.0);
  inform(scenario, method);
  return scenario;
}

/// A line of vehicles through the forest of the document, each with a LiDAR of 16 rows.
sim::Scenario forest_front(const Method& method, int n, std::uint64_t seed) {
  const std::string lidar = "vehicles[0].sensors[0].";
  sim::Scenario scenario = scenario_with("reproduce/rbl_forest.yaml", seed,
                                         {{lidar + "pattern.type", "uniform"},
                                          {lidar + "pattern.columns", "360"},
                                          {lidar + "pattern.rows", "16"},
                                          {lidar + "pattern.fov_vertical_deg", "60"},
                                          {lidar + "mount.rpy_deg", "[0, 0, 0]"}});
  scenario.recorders.clear();
  scenario.snapshots.clear();
  scenario.duration_s = 150.0;
  sim::VehicleConfig pattern = scenario.vehicles.front();
  pattern.sensors.push_back(
      scenario_with("reproduce/rbl_crossing.yaml", seed, {{"vehicles[0].sensors[0].ideal", "true"}})
          .vehicles.front()
          .sensors.front());
  choose(pattern, method);
  Module& guidance = pattern.agent.as<StackConfig>().guidance;
  if (guidance.type == "rbl") {
    auto& rbl = guidance.as<RblConfig>();
    rbl.neighbors.source = NeighborSourceConfig::Source::kSensor;
    rbl.lidar.fov_lower_deg = 90.0;  // the front half-sphere
    rbl.lidar.fov_deg = 180.0;
    rbl.lidar.facing_deg = 180.0;
  } else if (guidance.type == "pacnav") {
    guidance.as<PacnavConfig>().lidar.enabled = true;
  } else {
    guidance.as<MezeyConfig>().lidar.enabled = true;
  }
  scenario.vehicles.clear();
  for (int i = 0; i < n; ++i) {
    sim::VehicleConfig vehicle = pattern;
    vehicle.name = "uav" + std::to_string(i + 1);
    const double x = 4.0 * (i - 0.5 * (n - 1));
    vehicle.start.position_m = {x, -kForestEdge_m, 2.0};
    vehicle.start.yaw_deg = 90.0;
    set_goal(vehicle, {x, kForestEdge_m, 2.0});
    scenario.vehicles.push_back(std::move(vehicle));
  }
  inform(scenario, method);
  return scenario;
}

}  // namespace

// Equal flights with PACNav, the vision-based model and RBL; all measure neighbors without error.
void rbl_baselines(Experiment& experiment) {
  CsvTable csv({"case", "vehicles", "success", "arrived", "crashed", "length_m", "time_s", "min_separation_m"});
  const auto compare = [&](const std::string& place, int n, int seeds, const auto& make) {
    for (const Method& method : kMethods) {
      std::vector<sim::Scenario> scenarios;
      for (int seed = 1; seed <= seeds; ++seed) scenarios.push_back(make(method, n, static_cast<std::uint64_t>(seed)));
      const CrossingTable table = summarize(fly_crossings(experiment, scenarios), n);
      const std::string what = fmt::format("{} N={}, {}: ", place, n, method.name);
      csv.row(place + " " + std::string(method.guidance) + std::to_string(method.informed_every),
              {static_cast<double>(n), table.success, table.arrived, table.crashed, table.length_m.mean,
               table.time_s.mean, table.min_separation_m});
      experiment.row({what + "success [-]", fmt::format("{:.2f}", table.success), Verdict::kNotJudged,
                      fmt::format("{:.0f} % of the vehicles arrive, contact in {:.0f} % of the flights, least distance "
                                  "{:.2f} m",
                                  100.0 * table.arrived, 100.0 * table.crashed, table.min_separation_m),
                      table.success});
      if (table.success == 0.0) continue;
      experiment.row({what + "L [m], t [s]", fmt::format("{:.2f}, {:.2f}", table.length_m.mean, table.time_s.mean),
                      Verdict::kNotJudged, "of the flights that succeeded", table.time_s.mean});
    }
  };
  const int seeds = experiment.repetitions(100, 1);
  for (const int n : {5, 10}) compare("circle", n, seeds, circle);
  compare("forest", 5, std::max(1, seeds / 20), forest_front);
  experiment.write("baselines.csv", csv);
}

}  // namespace swiftlet::tools
