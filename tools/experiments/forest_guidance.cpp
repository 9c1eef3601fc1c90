// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "experiments.hpp"
#include "guidance_flights.hpp"
#include "parallel.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::tools {
namespace {

/// Distance to the border of the allowed space in the five flights of Table II.
constexpr std::array kBorders_m = {31.6, 36.5, 35.1, 41.6, 35.0};

/// The seed draws the forest. The guide localizes by LiDAR odometry that drifts.
sim::Scenario forest_flight(std::uint64_t seed, double border_m) {
  sim::Scenario scenario = scenario_with(
      "forest_guidance.yaml", seed,
      {{"vehicles[0].sensors",
        "[{type: lidar, name: os0, model: os0_128, mount: {position_m: [0, 0, 0.15]}}, "
        "{type: odometry, name: lio, model: odometry_lio}, {type: imu, name: imu, model: imu_adis16448}]"},
       {"vehicles[0].agent.localization", "{type: odometry}"},
       {"duration_s", "300"}});
  guide_of(scenario).advance.distance_m = border_m;
  return scenario;
}

}  // namespace

void forest_guidance(Experiment& experiment) {
  const int seeds = experiment.repetitions(20, 1);
  std::vector<sim::Scenario> scenarios;
  std::vector<double> borders_m;
  for (int seed = 1; seed <= seeds; ++seed) {
    borders_m.push_back(experiment.quick() ? 12.0 : kBorders_m[static_cast<std::size_t>(seed - 1) % kBorders_m.size()]);
    scenarios.push_back(forest_flight(static_cast<std::uint64_t>(seed), borders_m.back()));
  }
  const std::vector<GuidedFlight> flights =
      fly_guided(experiment, std::move(scenarios), std::vector<Passage>(borders_m.size(), Passage{1000.0}));

  CsvTable csv({"case", "seed", "done", "contact", "border_m", "flown_m", "time_s", "least_clearance_m", "seen_share"});
  int done = 0, contacts = 0;
  double least_m = 20.0, flown_m = 0.0, time_s = 0.0, seen_s = 0.0, guided_s = 0.0;
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const GuidedFlight& f = flights[i];
    done += f.done;
    contacts += f.crashed;
    least_m = std::min(least_m, f.least_clearance_m);
    flown_m += f.farthest_m;
    time_s += f.time_s;
    seen_s += f.seen_s;
    guided_s += f.guided_s;
    csv.row("forest", {static_cast<double>(i + 1), f.done ? 1.0 : 0.0, f.crashed ? 1.0 : 0.0, borders_m[i],
                       f.farthest_m, f.time_s, f.least_clearance_m, f.seen_s / std::max(f.guided_s, 1e-9)});
  }
  const double count = static_cast<double>(flights.size());
  experiment.at_least("flights that reach the border [%]", 100.0 * done / count, 100.0, 3,
                      fmt::format("{} of {}, each in another forest", done, flights.size()));
  experiment.at_most("contacts", contacts, 0.0, 1, fmt::format("least clearance {:.2f} m", least_m));
  experiment.row({"distance of a flight [m]", fmt::format("{:.1f}", flown_m / count), Verdict::kNotJudged,
                  fmt::format("mean, in {:.0f} s; the borders are the published distances", time_s / count),
                  flown_m / count});
  experiment.row({"share of the guided time with the secondary in sight [%]",
                  fmt::format("{:.1f}", 100.0 * seen_s / std::max(guided_s, 1e-9)), Verdict::kNotJudged, "",
                  100.0 * seen_s / std::max(guided_s, 1e-9)});
  experiment.write("flights.csv", csv);
  sim::plot::Figure figure("Distance flown in each forest", 1);
  sim::plot::Panel& panel = figure.add_panel();
  panel.x.label = "forest";
  panel.y.label = "distance [m]";
  panel.y.min = 0.0;
  std::vector<double> numbers, flown;
  for (std::size_t i = 0; i < flights.size(); ++i) {
    numbers.push_back(static_cast<double>(i + 1));
    flown.push_back(flights[i].farthest_m);
  }
  panel.scatter("flown", numbers, flown).line("border", numbers, borders_m, {.dash = sim::plot::Dash::kDashed});
  experiment.write("forest-guidance.svg", figure);
}

}  // namespace swiftlet::tools
