// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/agent/stack.hpp"
#include "core/guidance/rbl.hpp"
#include "crossing.hpp"
#include "experiments.hpp"
#include "sim/report/plot.hpp"
#include "sim/sensors/neighbors.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kCircleHeight_m = 5.0;   // the whole ball of the cell lies between the limits of Table 2.2
constexpr double kSphereHeight_m = 20.0;  // a sphere of 10 m does not fit between 1 and 10 m: limits moved along
constexpr double kNeed_m = 1.0;           // the sum of two encumbrances

struct CrossingCase {
  Formation formation;
  std::string variant;
  double length_m = 0.0, time_s = 0.0, slowest_s = 0.0;  // published; 0: not
};

sim::Scenario scenario_of(const CrossingCase& c, std::uint64_t seed, bool ideal) {
  sim::Scenario pattern = scenario_with("reproduce/rbl_crossing.yaml", seed);
  sim::VehicleConfig& vehicle = pattern.vehicles.front();
  RblConfig& rbl = vehicle.agent.as<StackConfig>().guidance.as<RblConfig>();
  rbl.variant = c.variant;
  if (c.formation.sphere) {
    rbl.z_min_m = 1.0;
    rbl.z_max_m = 2.0 * kSphereHeight_m;
  }
  if (ideal) vehicle.sensors.front().as<sim::NeighborsConfig>().ideal = true;
  return make_crossing(pattern, c.formation, c.formation.sphere ? kSphereHeight_m : kCircleHeight_m);
}

std::string case_name(const CrossingCase& c) {
  return fmt::format("{} N={} R={:g} {}", c.formation.sphere ? "sphere" : "circle", c.formation.num_vehicles,
                     c.formation.radius_m, c.variant);
}

/// Shorter or faster than published is better; up to a tenth more is reproduced.
void add_row(Experiment& experiment, const std::string& what, double published, const MeanAndDeviation& ours) {
  ResultRow row;
  row.what = what;
  row.published = fmt::format("{:.2f}", published);
  row.ours = fmt::format("{:.2f} ± {:.2f}", ours.mean, ours.deviation);
  row.value = ours.mean;
  row.verdict = ours.mean < 0.9 * published   ? Verdict::kBetter
                : ours.mean < 1.1 * published ? Verdict::kReproduced
                                              : Verdict::kDiffers;
  experiment.row(std::move(row));
}

CrossingTable fly_case(Experiment& experiment, const CrossingCase& c, int seeds, bool ideal, CsvTable& csv) {
  std::vector<sim::Scenario> scenarios;
  for (int seed = 1; seed <= seeds; ++seed)
    scenarios.push_back(scenario_of(c, static_cast<std::uint64_t>(seed), ideal));
  const CrossingTable table = summarize(fly_crossings(experiment, scenarios), c.formation.num_vehicles);
  csv.row(case_name(c) + (ideal ? " ideal" : " uvdar"),
          {static_cast<double>(seeds), table.success, table.length_m.mean, table.length_m.deviation, table.time_s.mean,
           table.time_s.deviation, table.slowest_s.mean, table.speed_mps.mean, table.min_separation_m});
  return table;
}

void compare(Experiment& experiment, const CrossingCase& c, const CrossingTable& table) {
  const std::string name = case_name(c);
  experiment.at_least(name + ": success [-]", "1", table.success, 1.0, 3);
  if (c.length_m <= 0.0) return;
  add_row(experiment, name + ": L [m]", c.length_m, table.length_m);
  add_row(experiment, name + ": t [s]", c.time_s, table.time_s);
  add_row(experiment, name + ": t_max [s]", c.slowest_s, table.slowest_s);
}

CsvTable crossing_csv() {
  return CsvTable({"case", "flights", "success", "length_m", "length_deviation_m", "time_s", "time_deviation_s",
                   "slowest_s", "speed_mps", "min_separation_m"});
}

/// With perfect neighbours nobody enters another's space, whatever the seed.
void check_safety(Experiment& experiment, const std::vector<CrossingCase>& cases, int seeds, CsvTable& csv) {
  for (const CrossingCase& c : cases) {
    const CrossingTable table = fly_case(experiment, c, seeds, true, csv);
    experiment.at_least(case_name(c) + ", perfect neighbours: least separation [m]", ">= 1.0", table.min_separation_m,
                        kNeed_m, 3, "sum of the encumbrances");
    experiment.at_least(case_name(c) + ", perfect neighbours: success [-]", "1", table.success, 1.0, 3);
  }
}

}  // namespace

void rbl_circle(Experiment& experiment) {
  const int seeds = experiment.repetitions(100, 2);
  CsvTable csv = crossing_csv();
  const std::vector<CrossingCase> cases = {
      {{false, 5, 10.0}, "2d", 21.06, 25.15, 25.15},          {{false, 5, 10.0}, "3d", 20.77, 26.04, 26.79},
      {{false, 5, 10.0}, "3d_clipped", 20.60, 26.73, 27.39},  {{false, 5, 10.0}, "3d_z", 20.97, 25.54, 26.72},
      {{false, 10, 10.0}, "2d", 22.95, 30.79, 34.73},         {{false, 10, 10.0}, "3d", 22.22, 30.05, 34.39},
      {{false, 10, 10.0}, "3d_clipped", 22.31, 30.22, 33.22}, {{false, 10, 10.0}, "3d_z", 22.38, 28.80, 32.35},
      {{false, 15, 10.0}, "2d", 23.56, 33.89, 38.75},         {{false, 15, 10.0}, "3d", 22.36, 30.65, 35.77},
      {{false, 15, 10.0}, "3d_clipped", 22.32, 30.69, 34.50}, {{false, 15, 10.0}, "3d_z", 22.64, 29.67, 34.27}};
  std::map<std::pair<std::string, int>, double> mean_time_s;
  for (const CrossingCase& c : cases) {
    const CrossingTable table = fly_case(experiment, c, seeds, false, csv);
    compare(experiment, c, table);
    mean_time_s[{c.variant, c.formation.num_vehicles}] = table.time_s.mean;
  }
  // The radius that the text prints.
  const CrossingCase printed{{false, 10, 5.0}, "3d_z"};
  const CrossingTable half = fly_case(experiment, printed, seeds, false, csv);
  experiment.row({case_name(printed) + ": L [m]", "22.38", fmt::format("{:.2f}", half.length_m.mean),
                  Verdict::kNotComparable, "the radius as printed; the published lengths need 10 m",
                  half.length_m.mean});
  const double gain = 1.0 - mean_time_s[{"3d_z", 15}] / mean_time_s[{"2d", 15}];
  experiment.at_least("N=15: 3D with z-rule faster than 2D by [%]", "4.22", 100.0 * gain, 4.0, 3,
                      "of the published means it is 12.5 %");
  check_safety(experiment, {{{false, 10, 10.0}, "2d"}, {{false, 15, 10.0}, "2d"}, {{false, 15, 10.0}, "3d_z"}}, seeds,
               csv);
  experiment.write("crossings.csv", csv);

  sim::plot::Figure figure("Circle of 10 m: mean time to the goal");
  sim::plot::Panel& panel = figure.add_panel("");
  panel.x.label = "vehicles";
  panel.y.label = "t [s]";
  const std::vector<double> counts = {5, 10, 15};
  for (const std::string variant : {"2d", "3d", "3d_clipped", "3d_z"}) {
    std::vector<double> times_s;
    for (const double n : counts) times_s.push_back(mean_time_s[{variant, static_cast<int>(n)}]);
    panel.line(variant, counts, times_s, {.marker = sim::plot::Marker::kCircle});
  }
  experiment.write("times.svg", figure);
}

void rbl_sphere(Experiment& experiment) {
  const int seeds = experiment.repetitions(100, 2);
  CsvTable csv = crossing_csv();
  for (const double radius_m : {5.0, 10.0}) {
    const bool fits = radius_m == 5.0;
    for (CrossingCase c : {CrossingCase{{true, 10, radius_m}, "3d", 14.32, 27.76, 32.48},
                           CrossingCase{{true, 10, radius_m}, "3d_z", 14.06, 27.17, 31.86}}) {
      if (!fits) c.length_m = 0.0;
      const CrossingTable table = fly_case(experiment, c, seeds, false, csv);
      compare(experiment, c, table);
      if (fits) continue;
      experiment.row({case_name(c) + ": L [m]", "-", fmt::format("{:.2f}", table.length_m.mean),
                      Verdict::kNotComparable, "the circle's radius; the published lengths fit 5 m",
                      table.length_m.mean});
    }
  }
  check_safety(experiment, {{{true, 10, 5.0}, "3d"}, {{true, 10, 5.0}, "3d_z"}}, seeds, csv);
  // Beyond the document: how many fit?
  for (const int n : {30, 60}) {
    const CrossingCase c{{true, n, 10.0}, "3d_z"};
    const CrossingTable table = fly_case(experiment, c, experiment.repetitions(10, 1), true, csv);
    experiment.row({case_name(c) + ", perfect neighbours: success [-]", "-", fmt::format("{:.2f}", table.success),
                    Verdict::kNotComparable, fmt::format("least separation {:.2f} m", table.min_separation_m),
                    table.success});
  }
  experiment.write("crossings.csv", csv);
}

}  // namespace swiftlet::tools
