// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "experiments.hpp"
#include "parallel.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/rbl.hpp"

namespace swiftlet::tools {
namespace {

struct ForestFlights {
  double success = 0.0, least_clearance_m = std::numeric_limits<double>::infinity();
  MeanAndDeviation length_m, time_s;
};

ForestFlights fly_forest(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios, CsvTable& csv,
                         const std::string& name) {
  const std::vector<sim::RunSummary> runs = fly(experiment, scenarios);
  const std::string vehicle = scenarios.front().vehicles.front().name;
  const std::vector<double> time_s = metric_of(runs, "time_to_done_s", vehicle);
  const std::vector<double> length_m = metric_of(runs, "path_length_m", vehicle);
  const std::vector<double> clearance_m = metric_of(runs, "min_clearance_surface_m", vehicle);
  ForestFlights result;
  std::vector<double> arrived_length_m, arrived_time_s;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const bool done = runs[i].outcome == "done";
    csv.row(name, {static_cast<double>(runs[i].seed), done ? 1.0 : 0.0, length_m[i], time_s[i], clearance_m[i]});
    result.least_clearance_m = std::min(result.least_clearance_m, clearance_m[i]);
    if (!done) continue;
    arrived_length_m.push_back(length_m[i]);
    arrived_time_s.push_back(time_s[i]);
  }
  result.success = static_cast<double>(arrived_length_m.size()) / static_cast<double>(runs.size());
  result.length_m = mean_and_deviation(arrived_length_m);
  result.time_s = mean_and_deviation(arrived_time_s);
  return result;
}

sim::Scenario forest(std::uint64_t seed, std::vector<std::pair<std::string, std::string>> changes = {}) {
  sim::Scenario scenario = scenario_with("reproduce/rbl_forest.yaml", seed, std::move(changes));
  scenario.recorders.clear();
  scenario.snapshots.clear();
  scenario.metrics.stop_on_crash = true;
  return scenario;
}

RblConfig& rbl_of(sim::Scenario& scenario) {
  return scenario.vehicles.front().agent.as<StackConfig>().guidance.as<RblConfig>();
}

/// Not comparable: the published flights use another reference tracker.
void tell_time(Experiment& experiment, const ForestFlights& flights) {
  experiment.row({"t [s]", fmt::format("{:.2f} ± {:.2f}", flights.time_s.mean, flights.time_s.deviation),
                  Verdict::kOtherConditions, "the printed v of 0.85 m/s does not fit L / t = 0.61 m/s",
                  flights.time_s.mean});
}

}  // namespace

void rbl_forest(Experiment& experiment) {
  const int seeds = experiment.repetitions(100, 1);
  CsvTable csv({"case", "seed", "success", "length_m", "time_s", "least_clearance_m"});
  std::vector<sim::Scenario> scenarios;
  for (int seed = 1; seed <= seeds; ++seed) scenarios.push_back(forest(static_cast<std::uint64_t>(seed)));
  const ForestFlights flights = fly_forest(experiment, scenarios, csv, "forest");
  experiment.at_least("success [-]", flights.success, 1.0, 3, "another forest for each seed");
  experiment.at_most("L [m]", flights.length_m.mean, 1.1 * experiment.published("L [m]").value, 4);
  tell_time(experiment, flights);
  experiment.at_least("least clearance of the whole vehicle [m]", flights.least_clearance_m, 0.0, 3);
  experiment.write("flights.csv", csv);
}

void rbl_forest_files(Experiment& experiment) {
  const int seeds = experiment.repetitions(100, 1);
  CsvTable csv({"case", "seed", "success", "length_m", "time_s", "least_clearance_m"});
  const std::string agent = "vehicles[0].agent.";
  std::vector<sim::Scenario> scenarios;
  for (int seed = 1; seed <= seeds; ++seed) {
    scenarios.push_back(forest(static_cast<std::uint64_t>(seed), {{agent + "guidance.model", "rbl_thesis_files"},
                                                                  {agent + "guidance.cells.step_m", "0.5"},
                                                                  {agent + "mapping.edge_m", "0.3"}}));
  }
  const ForestFlights flights = fly_forest(experiment, scenarios, csv, "forest");
  experiment.at_least("success [-]", flights.success, 1.0, 3, "another forest for each seed");
  experiment.at_most("L [m]", flights.length_m.mean, 1.1 * experiment.published("L [m]").value, 4);
  tell_time(experiment, flights);
  experiment.at_least("least clearance of the whole vehicle [m]", flights.least_clearance_m, 0.0, 3);
  experiment.write("flights.csv", csv);
}

void rbl_real(Experiment& experiment) {
  const int seeds = experiment.repetitions(10, 1);
  CsvTable csv({"case", "seed", "success", "length_m", "time_s", "least_clearance_m"});
  // The two columns of Table 3.2 are printed equal, although the text mentions scaled cells and weighting.
  struct Flight {
    const char* name;
    double goal_m, speed_mps;
  };
  for (const Flight& flight : {Flight{"conservative", 45.0, 0.55}, Flight{"aggressive", 32.0, 0.8}}) {
    std::vector<sim::Scenario> scenarios;
    for (int seed = 1; seed <= seeds; ++seed) {
      sim::Scenario scenario = forest(static_cast<std::uint64_t>(seed));
      const Eigen::Vector3d start = scenario.vehicles.front().start.position_m;
      RblConfig& rbl = rbl_of(scenario);
      const Eigen::Vector3d way = rbl.goal_m - start;
      rbl.goal_m = start + flight.goal_m / way.norm() * way;
      rbl.speed_mps = flight.speed_mps;
      scenarios.push_back(std::move(scenario));
    }
    const ForestFlights ours = fly_forest(experiment, scenarios, csv, flight.name);
    experiment.at_least(fmt::format("{}: success [-]", flight.name), ours.success, 1.0, 3);
    experiment.row({fmt::format("{}: L [m]", flight.name), fmt::format("{:.2f}", ours.length_m.mean),
                    Verdict::kNotJudged, "neither the forest nor the parameters were published", ours.length_m.mean});
    experiment.row({fmt::format("{}: t [s]", flight.name), fmt::format("{:.2f}", ours.time_s.mean), Verdict::kNotJudged,
                    "at the published mean speed", ours.time_s.mean});
  }
  experiment.write("flights.csv", csv);
}

}  // namespace swiftlet::tools
