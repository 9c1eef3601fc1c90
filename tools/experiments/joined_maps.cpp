// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "experiments.hpp"
#include "parallel.hpp"
#include "slam_flights.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kLinks_kbps[] = {10.0, 50.0, 250.0, 1000.0};
constexpr double kShareOfLink = 0.8;  // radio budget of map sharing
constexpr double kBar_m = 0.1;
constexpr double kFalseJoin_m = 0.5;  // larger errors of a join count as false

sim::Scenario joining_flight(double link_kbps, std::uint64_t seed) {
  const std::string budget = fmt::format("{}", kShareOfLink * link_kbps);
  return scenario_with("join_maps", seed,
                       {{"radio.rate_kbps", fmt::format("{}", link_kbps)},
                        {"vehicles[0].agent.localization.global.share.budget_kbps", budget},
                        {"vehicles[1].agent.localization.global.share.budget_kbps", budget}});
}

/// Two vehicles in aisles that look alike, with LiDARs that see neither the ends of the aisles nor over the racks. They
/// never share an aisle.
sim::Scenario aisle_flight(std::uint64_t seed) {
  std::vector<std::pair<std::string, std::string>> changes = {{"world", "{type: warehouse, door_width_m: 1.2}"},
                                                              {"snapshots", "[]"},
                                                              {"radio.rate_kbps", "1000"},
                                                              {"duration_s", "40"}};
  for (int i = 0; i < 2; ++i) {
    const std::string vehicle = fmt::format("vehicles[{}].", i);
    changes.emplace_back(vehicle + "model", "x500");
    changes.emplace_back(vehicle + "start.position_m", i == 0 ? "[-10, -5.68, 3.6]" : "[10, 5.68, 3.6]");
    changes.emplace_back(vehicle + "start.yaw_deg", i == 0 ? "0" : "180");
    changes.emplace_back(vehicle + "agent.localization.local.range_max_m", "9");
    changes.emplace_back(vehicle + "agent.localization.global.share.budget_kbps", "800");
    changes.emplace_back(vehicle + "agent.guidance.waypoints_m", "[[20, 0, 0], [0, 0, 0], [20, 0, 0]]");
  }
  return scenario_with("join_maps", seed, std::move(changes));
}

struct LinkResults {
  double link_kbps = 0.0;
  std::vector<double> joined_s, end_m, worst_m, yaw_deg, nees, looks_kB, clouds_kB, words_kB;
};

double sum_over(const std::vector<sim::RunSummary>& runs, std::size_t i, const std::string& name) {
  double sum = 0.0;
  for (const char* vehicle : {"uav1", "uav2"}) {
    const double value = metric_of({runs[i]}, name, vehicle).front();
    if (!std::isnan(value)) sum += value;
  }
  return sum;
}

/// Larger value of both vehicles.
double worse_of(const std::vector<sim::RunSummary>& runs, std::size_t i, const std::string& name) {
  const double a = metric_of({runs[i]}, name, "uav1").front(), b = metric_of({runs[i]}, name, "uav2").front();
  return std::isnan(a) || std::isnan(b) ? std::nan("") : std::max(a, b);
}

int count_of(const std::vector<double>& values) {
  return static_cast<int>(std::count_if(values.begin(), values.end(), [](double x) { return !std::isnan(x); }));
}

double worst_known(const std::vector<double>& values) {
  double worst = std::nan("");
  for (const double x : values) worst = std::isnan(x) ? worst : std::isnan(worst) ? x : std::max(worst, x);
  return worst;
}

void plot_links(Experiment& experiment, const std::vector<LinkResults>& links) {
  sim::plot::Figure figure("Two vehicles join their maps, by what the link carries", 1);
  figure.set_panel_size(760, 300);
  sim::plot::Panel& off = figure.add_panel("pose of one local frame in the other, at the end of the flight");
  sim::plot::Panel& when = figure.add_panel("when the maps were joined");
  off.y.label = "error where the other is [m]";
  when.y.label = "time after the start [s]";
  std::vector<double> x, y, joined;
  for (const LinkResults& link : links) {
    for (std::size_t i = 0; i < link.end_m.size(); ++i) {
      if (std::isnan(link.end_m[i])) continue;
      x.push_back(link.link_kbps);
      y.push_back(link.end_m[i]);
      joined.push_back(link.joined_s[i]);
    }
  }
  for (sim::plot::Panel* panel : {&off, &when}) {
    panel->x.label = "rate of the link [kbit/s]";
    panel->x.log = true;
  }
  off.y.log = true;
  off.scatter("a flight, the worse of both vehicles", x, y, {.marker_px = 4.0});
  off.line("bar", std::vector<double>{8.0, 1250.0}, std::vector<double>{kBar_m, kBar_m}, {.color = 1});
  when.scatter("a flight, the later of both vehicles", x, joined, {.marker_px = 4.0});
  experiment.write("joined-maps.svg", figure);
}

}  // namespace

void joined_maps(Experiment& experiment) {
  const int seeds = experiment.repetitions(5, 1), aisle_seeds = std::max(1, seeds);
  std::vector<sim::Scenario> scenarios;
  for (const double link_kbps : kLinks_kbps) {
    for (int seed = 1; seed <= seeds; ++seed) {
      scenarios.push_back(joining_flight(link_kbps, static_cast<std::uint64_t>(seed)));
    }
  }
  for (int seed = 1; seed <= aisle_seeds; ++seed) scenarios.push_back(aisle_flight(static_cast<std::uint64_t>(seed)));
  for (sim::Scenario& scenario : scenarios) {
    scenario.recorders.clear();
    scenario.snapshots.clear();
  }
  const std::vector<sim::RunSummary> runs = fly(experiment, scenarios);

  CsvTable csv({"case", "link_kbps", "seed", "joined_s", "end_m", "worst_m", "end_deg", "nees", "looks_kB", "clouds_kB",
                "words_kB"});
  std::vector<LinkResults> links;
  std::size_t i = 0;
  const auto note = [&](const char* name, LinkResults& results, int seed) {
    results.joined_s.push_back(worse_of(runs, i, "joined_s"));
    results.end_m.push_back(worse_of(runs, i, "joined_position_end_m"));
    results.worst_m.push_back(worse_of(runs, i, "joined_position_max_m"));
    results.yaw_deg.push_back(worse_of(runs, i, "joined_yaw_end_rad") * 180.0 / 3.14159265358979);
    results.nees.push_back(worse_of(runs, i, "joined_nees"));
    results.looks_kB.push_back(1e-3 * sum_over(runs, i, "map_looks_bytes"));
    results.clouds_kB.push_back(1e-3 * sum_over(runs, i, "map_clouds_bytes"));
    results.words_kB.push_back(1e-3 * sum_over(runs, i, "map_words_bytes"));
    csv.row(name, {results.link_kbps, static_cast<double>(seed), results.joined_s.back(), results.end_m.back(),
                   results.worst_m.back(), results.yaw_deg.back(), results.nees.back(), results.looks_kB.back(),
                   results.clouds_kB.back(), results.words_kB.back()});
    ++i;
  };
  for (const double link_kbps : kLinks_kbps) {
    LinkResults& link = links.emplace_back();
    link.link_kbps = link_kbps;
    for (int seed = 1; seed <= seeds; ++seed) note("campus", link, seed);
  }
  LinkResults aisles;
  aisles.link_kbps = 1000.0;
  int joins = 0, false_joins = 0;
  for (int seed = 1; seed <= aisle_seeds; ++seed) {
    for (const char* vehicle : {"uav1", "uav2"}) {
      const double worst_m = metric_of({runs[i]}, "joined_position_max_m", vehicle).front();
      joins += !std::isnan(worst_m);
      false_joins += worst_m > kFalseJoin_m;
    }
    note("aisles", aisles, seed);
  }
  experiment.write("flights.csv", csv);

  for (const LinkResults& link : links) {
    const int joined = count_of(link.end_m);
    experiment.at_least(fmt::format("{:.0f} kbit/s: flights in which both joined their maps [%]", link.link_kbps),
                        100.0 * joined / static_cast<double>(link.end_m.size()), 100.0, 3,
                        fmt::format("{} of {}", joined, link.end_m.size()));
    experiment.at_most(
        fmt::format("{:.0f} kbit/s: error of the relative pose at the end [m]", link.link_kbps), median_of(link.end_m),
        kBar_m, 2,
        fmt::format("median; worst {} m; worst at any time {} m; heading {} degrees; normalized squared error {}",
                    short_number(worst_known(link.end_m), 2), short_number(worst_known(link.worst_m), 2),
                    short_number(median_of(link.yaw_deg), 2), short_number(median_of(link.nees), 2)));
    experiment.row({fmt::format("{:.0f} kbit/s: joined after [s]", link.link_kbps),
                    short_number(median_of(link.joined_s), 3), Verdict::kNotJudged,
                    fmt::format("median; latest {} s; both sent {} kB of clouds, {} kB of descriptors and {} kB of "
                                "other words",
                                short_number(worst_known(link.joined_s), 3), short_number(median_of(link.clouds_kB), 3),
                                short_number(median_of(link.looks_kB), 3), short_number(median_of(link.words_kB), 3)),
                    median_of(link.joined_s)});
  }
  experiment.at_most("equal aisles: false joins", false_joins, 0.0, 1,
                     fmt::format("{} flights of two vehicles, {} joins at all; {} kB of clouds a flight", aisle_seeds,
                                 joins, short_number(median_of(aisles.clouds_kB), 3)));
  plot_links(experiment, links);
}

}  // namespace swiftlet::tools
