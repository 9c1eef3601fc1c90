// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "crossing.hpp"
#include "experiments.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/sim/plot/plot.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kSphereMiddle_m = 20.0;

/// Results over increasing values of one quantity.
struct Sweep {
  std::vector<double> values;
  std::vector<double> success, least_m, time_s;

  void add(double value, double share, double nearest_m, double mean_time_s) {
    values.push_back(value);
    success.push_back(share);
    least_m.push_back(nearest_m);
    time_s.push_back(mean_time_s);
  }
};

void draw(Experiment& experiment, const std::string& file, const std::string& title, const std::string& quantity,
          const std::string& nearest, const Sweep& sweep) {
  sim::plot::Figure figure(title, 3);
  figure.set_panel_size(330, 260);
  const auto panel = [&](const std::string& label, const std::vector<double>& values) {
    sim::plot::Panel& p = figure.add_panel("");
    p.x.label = quantity;
    p.y.label = label;
    p.y.min = 0.0;
    p.legend = sim::plot::Legend::kNone;
    p.line("", sweep.values, values, {.marker = sim::plot::Marker::kCircle});
  };
  panel("success [-]", sweep.success);
  panel(nearest, sweep.least_m);
  panel("mean time [s]", sweep.time_s);
  experiment.write(file, figure);
}

void add(Experiment& experiment, const std::string& what, double success, double least_m) {
  experiment.row({what + ": success [-]", fmt::format("{:.2f}", success), Verdict::kNotJudged,
                  fmt::format("least distance {:.2f} m", least_m), success});
}

/// Increasing numbers of vehicles on a sphere of 10 m, with perfect neighbor measurements.
void crowd(Experiment& experiment, int seeds, CsvTable& csv) {
  Sweep sweep;
  for (const int n : experiment.quick() ? std::vector<int>{15, 30} : std::vector<int>{10, 20, 30, 45, 60, 90}) {
    std::vector<sim::Scenario> scenarios;
    for (int seed = 1; seed <= seeds; ++seed) {
      sim::Scenario pattern = scenario_with("reproduce/rbl_crossing.yaml", static_cast<std::uint64_t>(seed));
      sim::VehicleConfig& vehicle = pattern.vehicles.front();
      vehicle.sensors.front().as<sim::NeighborsConfig>().ideal = true;
      vehicle.agent.as<StackConfig>().guidance.as<RblConfig>().z_max_m = 2.0 * kSphereMiddle_m;
      scenarios.push_back(make_crossing(pattern, {true, n, 10.0}, kSphereMiddle_m));
    }
    const CrossingTable table = summarize(fly_crossings(experiment, scenarios), n);
    csv.row("vehicles", {static_cast<double>(n), table.success, table.min_separation_m, table.time_s.mean});
    sweep.add(n, table.success, table.min_separation_m, table.time_s.mean);
    add(experiment, fmt::format("sphere of 10 m, {} vehicles, perfect neighbors", n), table.success,
        table.min_separation_m);
  }
  draw(experiment, "crowd.svg", "Sphere of 10 m, perfect neighbors", "vehicles", "least distance [m]", sweep);
}

/// Ten vehicles on a circle, with neighbor measurements of decreasing quality.
void knowledge(Experiment& experiment, int seeds, const std::string& what, const std::vector<double>& values,
               void (*set)(sim::NeighborsConfig&, double), CsvTable& csv) {
  Sweep sweep;
  for (const double value : values) {
    std::vector<sim::Scenario> scenarios;
    for (int seed = 1; seed <= seeds; ++seed) {
      sim::Scenario pattern = scenario_with("reproduce/rbl_crossing.yaml", static_cast<std::uint64_t>(seed));
      set(pattern.vehicles.front().sensors.front().as<sim::NeighborsConfig>(), value);
      scenarios.push_back(make_crossing(pattern, {false, 10, 10.0}, 5.0));
    }
    const CrossingTable table = summarize(fly_crossings(experiment, scenarios), 10);
    csv.row(what, {value, table.success, table.min_separation_m, table.time_s.mean});
    sweep.add(value, table.success, table.min_separation_m, table.time_s.mean);
    add(experiment, fmt::format("circle N=10, {} {:g}", what, value), table.success, table.min_separation_m);
  }
  draw(experiment, what.substr(0, what.find(' ')) + ".svg", "Ten vehicles, circle of 10 m", what, "least distance [m]",
       sweep);
}

/// The forest of the document with increasing numbers of trees.
void density(Experiment& experiment, int seeds, CsvTable& csv) {
  Sweep sweep;
  for (const int trees : experiment.quick() ? std::vector<int>{100} : std::vector<int>{100, 200, 300, 400, 500}) {
    std::vector<sim::Scenario> scenarios;
    for (int seed = 1; seed <= seeds; ++seed) {
      sim::Scenario scenario = scenario_with(
          "reproduce/rbl_forest.yaml", static_cast<std::uint64_t>(seed),
          {{"world.num_trees", std::to_string(trees)}, {"world.min_distance_m", trees > 100 ? "1.5" : "3"}});
      scenario.recorders.clear();
      scenario.snapshots.clear();
      scenario.metrics.stop_on_crash = true;
      scenario.duration_s = 120.0;
      scenarios.push_back(std::move(scenario));
    }
    const std::vector<sim::RunSummary> runs = fly(experiment, scenarios);
    const std::string vehicle = scenarios.front().vehicles.front().name;
    const std::vector<double> clearance_m = metric_of(runs, "min_clearance_surface_m", vehicle);
    const std::vector<double> time_s = metric_of(runs, "time_to_done_s", vehicle);
    double success = 0.0, least_m = clearance_m.front();
    for (std::size_t i = 0; i < runs.size(); ++i) {
      success += runs[i].outcome == "done" ? 1.0 / static_cast<double>(runs.size()) : 0.0;
      least_m = std::min(least_m, clearance_m[i]);
    }
    csv.row("trees", {static_cast<double>(trees), success, least_m, mean_and_deviation(time_s).mean});
    sweep.add(trees, success, least_m, mean_and_deviation(time_s).mean);
    add(experiment, fmt::format("forest of {} trees", trees), success, least_m);
  }
  draw(experiment, "forest.svg", "Forest of 40 m x 64 m, Mid-360", "trees", "least clearance [m]", sweep);
}

}  // namespace

void rbl_limits(Experiment& experiment) {
  CsvTable csv({"sweep", "value", "success", "least_m", "time_s"});
  const int seeds = experiment.repetitions(10, 1);
  const bool quick = experiment.quick();
  crowd(experiment, std::max(1, seeds / 2), csv);
  knowledge(
      experiment, seeds, "noise of the range, share of it",
      quick ? std::vector<double>{0.2} : std::vector<double>{0.0, 0.1, 0.2, 0.3, 0.4, 0.6},
      [](sim::NeighborsConfig& c, double value) { c.sigma_range_relative = value; }, csv);
  knowledge(
      experiment, seeds, "delay of the positions [s]",
      quick ? std::vector<double>{0.3} : std::vector<double>{0.0, 0.1, 0.2, 0.4, 0.6, 0.8},
      [](sim::NeighborsConfig& c, double value) { c.latency_s = value; }, csv);
  density(experiment, std::max(1, seeds / 2), csv);
  experiment.write("limits.csv", csv);
}

}  // namespace swiftlet::tools
