// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "experiments.hpp"
#include "parallel.hpp"
#include "slam_flights.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::tools {
namespace {

/// Fig. 6: the map built during the flight, and the flown path.
void plot_map(Experiment& experiment, const SlamFlight& flight) {
  sim::plot::Figure figure(
      fmt::format("Cells of the map at {:.1f} m, and the path that was flown (Fig. 6)", SlamFlight::kSlice_m), 1);
  figure.set_panel_size(640, 560);
  sim::plot::Panel& panel = figure.add_panel();
  panel.equal_axes = true;
  panel.x.label = "x [m]";
  panel.y.label = "y [m]";
  panel.x.min = -25.0;
  panel.x.max = 25.0;
  std::vector<double> x_m, y_m, shown_x_m, shown_y_m, true_x_m, true_y_m;
  for (const Eigen::Vector2d& p : flight.slice_world_m) {
    if (p.cwiseAbs().maxCoeff() > 25.0) continue;
    x_m.push_back(p.x());
    y_m.push_back(p.y());
  }
  for (const SlamMoment& m : flight.moments) {
    shown_x_m.push_back(m.p_shown_m.x());
    shown_y_m.push_back(m.p_shown_m.y());
    true_x_m.push_back(m.p_true_m.x());
    true_y_m.push_back(m.p_true_m.y());
  }
  panel.scatter("occupied", x_m, y_m, {.color = 7, .marker = sim::plot::Marker::kSquare, .marker_px = 1.0});
  panel.line("as the vehicle knows it", shown_x_m, shown_y_m, {.color = 0});
  panel.line("true", true_x_m, true_y_m, {.color = 1, .dash = sim::plot::Dash::kDashed});
  experiment.write("submap-navigation.svg", figure);
}

}  // namespace

void submap_navigation(Experiment& experiment) {
  const int seeds = experiment.repetitions(20, 1);
  std::vector<sim::Scenario> scenarios;
  for (int seed = 1; seed <= seeds; ++seed) {
    scenarios.push_back(scenario_with("submap_navigation", static_cast<std::uint64_t>(seed)));
  }
  const std::vector<SlamFlight> flights = fly_on_slam(experiment, std::move(scenarios));
  CsvTable csv({"case", "seed", "done", "contact", "lost_s", "way_m", "time_s", "least_clearance_m", "rms_m",
                "rms_local_after_m", "rms_after_m", "closures", "false_closures", "revisits", "revisits_closed",
                "largest_correction_m"});
  int done = 0, contacts = 0;
  double least_m = 1e9, largest_m = 0.0;
  ClosureCount sum;
  std::vector<double> local_m, after_m;
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const SlamFlight& f = flights[i];
    done += f.done;
    contacts += f.crashed;
    least_m = std::min(least_m, f.least_clearance_m);
    largest_m = std::max(largest_m, f.correction.largest_m);
    sum.closed += f.closures.closed;
    sum.false_ones += f.closures.false_ones;
    sum.revisits += f.closures.revisits;
    sum.revisits_closed += f.closures.revisits_closed;
    local_m.push_back(f.rms_local_after_m);
    after_m.push_back(f.rms_after_m);
    csv.row("campus",
            {static_cast<double>(i + 1), f.done ? 1.0 : 0.0, f.crashed ? 1.0 : 0.0, f.lost_s, f.way_m, f.time_s,
             f.least_clearance_m, f.rms_m, f.rms_local_after_m, f.rms_after_m, static_cast<double>(f.closures.closed),
             static_cast<double>(f.closures.false_ones), static_cast<double>(f.closures.revisits),
             static_cast<double>(f.closures.revisits_closed), f.correction.largest_m});
  }
  const double count = static_cast<double>(flights.size());
  experiment.claim("a path is planned in the map of submaps, and flown",
                   fmt::format("{} of {} flights", done, flights.size()), done == static_cast<int>(flights.size()),
                   fmt::format("twice around the building; least clearance {:.2f} m", least_m));
  experiment.at_most("contacts", contacts, 0.0, 1);
  experiment.at_most("false closures", sum.false_ones, 0.0, 1, fmt::format("of {}", sum.closed));
  experiment.at_least(
      "revisits that were closed [%]", 100.0 * sum.revisits_closed / std::max(sum.revisits, 1), 95.0, 3,
      fmt::format("{} of {}, {:.1f} a flight", sum.revisits_closed, sum.revisits, sum.revisits / std::max(count, 1.0)));
  experiment.row(
      {"error of the position after the first closure [m]", short_number(median_of(after_m), 2), Verdict::kNotJudged,
       fmt::format("median of root mean squares; by local SLAM alone {:.2f} m; corrections of up to {:.2f} m",
                   median_of(local_m), largest_m),
       median_of(after_m)});
  experiment.write("flights.csv", csv);
  plot_map(experiment, flights.front());
}

}  // namespace swiftlet::tools
