// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "experiments.hpp"
#include "parallel.hpp"
#include "slam_flights.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::tools {
namespace {

/// A closed path in a world, free of obstacles for every seed.
struct DriftWorld {
  const char* scenario;
  const char* start_m;
  const char* waypoints_m;
  double round_m;
  double agile_mps;
  bool costly;  // many leaves: left out of quick versions
  const char* more_key = "";
  const char* more = "";
};
constexpr DriftWorld kDriftWorlds[] = {
    {"campus", "[-12.5, -10, 3]", "[[12.5, -10, 3], [12.5, 10, 4], [-12.5, 10, 4], [-12.5, -10, 3]]", 90.0, 6.0, false},
    {"forest", "[-27, -12, 4]",
     "[[-12, -8, 4], [0, 0, 4], [10, 12, 4], [27, 15, 4], [10, 12, 4], [0, 0, 4], [-12, -8, 4], [-27, -12, 4]]", 126.0,
     4.0, true},
    {"warehouse", "[-17.3, -5.68, 3.6]", "[[17.3, -5.68, 3.6], [17.3, 0, 3.6], [-17.3, 0, 3.6], [-17.3, -5.68, 3.6]]",
     80.5, 5.0, false},
    {"hall", "[-5, -3, 2]", "[[5, -3, 2.5], [5, 3, 2], [-5, 3, 2.5], [-5, -3, 2]]", 32.0, 4.0, false},
    {"field", "[-12, -12, 4]", "[[12, -12, 4], [12, 12, 4.5], [-12, 12, 4], [-12, -12, 4]]", 96.0, 6.0, true,
     "world.num_trees", "60"},
};

struct DriftLidar {
  const char* model;
  const char* label;
  double limit_percent;  // median drift of local SLAM
};
constexpr DriftLidar kDriftLidars[] = {
    {"puck_lite", "Puck LITE", 0.6}, {"os1_128", "OS1-128", 0.3}, {"mid360", "Mid-360", 0.3}};

sim::Scenario round_flight(const DriftWorld& world, const DriftLidar& lidar, bool agile, double way_m,
                           std::uint64_t seed) {
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
      {"vehicles[0].agent.localization", "{type: slam, global: {enabled: true}}"},
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

struct DriftCase {
  const DriftWorld* world;
  const DriftLidar* lidar;
  bool agile;
  std::uint64_t seed;
};

using DriftChoice = std::function<bool(const DriftCase&)>;

/// Statistics over the flights of selected cases.
class DriftFlights {
 public:
  DriftFlights(std::vector<DriftCase> cases, std::vector<SlamFlight> flights)
      : cases_(std::move(cases)), flights_(std::move(flights)) {}

  std::vector<double> values(const DriftChoice& wanted, double SlamFlight::*value) const {
    std::vector<double> found;
    for (std::size_t i = 0; i < cases_.size(); ++i) {
      if (wanted(cases_[i]) && std::isfinite(flights_[i].*value)) found.push_back(flights_[i].*value);
    }
    return found;
  }
  double median(const DriftChoice& wanted, double SlamFlight::*value) const { return median_of(values(wanted, value)); }
  double worst(const DriftChoice& wanted, double SlamFlight::*value) const {
    const std::vector<double> all = values(wanted, value);
    return all.empty() ? std::nan("") : *std::max_element(all.begin(), all.end());
  }
  /// "campus 0.021, forest 0.034": medians by world.
  std::string by_world(const DriftChoice& wanted, double SlamFlight::*value, int digits) const {
    std::string text;
    for (const DriftWorld& world : kDriftWorlds) {
      const double of_world = median([&](const DriftCase& c) { return wanted(c) && c.world == &world; }, value);
      if (!std::isfinite(of_world)) continue;
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", world.scenario, short_number(of_world, digits));
    }
    return text;
  }
  ClosureCount closures(const DriftChoice& wanted) const {
    ClosureCount sum;
    for (std::size_t i = 0; i < cases_.size(); ++i) {
      if (!wanted(cases_[i])) continue;
      const ClosureCount& c = flights_[i].closures;
      sum.closed += c.closed;
      sum.false_ones += c.false_ones;
      sum.revisits += c.revisits;
      sum.revisits_closed += c.revisits_closed;
      sum.worst_m = std::max(sum.worst_m, c.worst_m);
    }
    return sum;
  }
  const std::vector<DriftCase>& cases() const { return cases_; }
  const std::vector<SlamFlight>& flights() const { return flights_; }

 private:
  std::vector<DriftCase> cases_;
  std::vector<SlamFlight> flights_;
};

void write_drift_csv(Experiment& experiment, const DriftFlights& all) {
  CsvTable csv({"world",
                "lidar",
                "agile",
                "seed",
                "contact",
                "lost_s",
                "way_m",
                "time_s",
                "drift_10m_percent",
                "drift_50m_percent",
                "rms_m",
                "rms_local_after_m",
                "rms_after_m",
                "end_m",
                "nees",
                "closures",
                "false_closures",
                "worst_closure_m",
                "revisits",
                "revisits_closed",
                "graph_rms_m"});
  for (std::size_t i = 0; i < all.cases().size(); ++i) {
    const DriftCase& c = all.cases()[i];
    const SlamFlight& f = all.flights()[i];
    csv.row(c.world->scenario, {static_cast<double>(c.lidar - kDriftLidars),
                                c.agile ? 1.0 : 0.0,
                                static_cast<double>(c.seed),
                                f.crashed ? 1.0 : 0.0,
                                f.lost_s,
                                f.way_m,
                                f.time_s,
                                f.drift_10m_percent,
                                f.drift_50m_percent,
                                f.rms_m,
                                f.rms_local_after_m,
                                f.rms_after_m,
                                f.end_m,
                                f.nees,
                                static_cast<double>(f.closures.closed),
                                static_cast<double>(f.closures.false_ones),
                                f.closures.worst_m,
                                static_cast<double>(f.closures.revisits),
                                static_cast<double>(f.closures.revisits_closed),
                                f.graph.rms_m});
  }
  experiment.write("flights.csv", csv);
}

void plot_drift(Experiment& experiment, const DriftFlights& all) {
  sim::plot::Figure figure("SLAM without anything else, by world", 1);
  figure.set_panel_size(760, 320);
  sim::plot::Panel& drift = figure.add_panel("drift of local SLAM over 50 m, median");
  sim::plot::Panel& off = figure.add_panel("position after closures, root mean square of a flight, median");
  drift.y.label = "drift [% of the way]";
  off.y.label = "error [m]";
  for (sim::plot::Panel* panel : {&drift, &off}) {
    panel->y.log = true;
    for (const DriftWorld& world : kDriftWorlds) panel->x.categories.emplace_back(world.scenario);
  }
  int color = 0;
  for (const DriftLidar& lidar : kDriftLidars) {
    for (const bool agile : {false, true}) {
      std::vector<double> x, drifts, offs;
      for (const DriftWorld& world : kDriftWorlds) {
        const DriftChoice these = [&](const DriftCase& c) {
          return c.world == &world && c.lidar == &lidar && c.agile == agile;
        };
        x.push_back(static_cast<double>(x.size()) + 0.1 * (color - 2.5));  // side by side within a world
        drifts.push_back(all.median(these, &SlamFlight::drift_50m_percent));
        offs.push_back(all.median(these, &SlamFlight::rms_after_m));
      }
      const std::string label = fmt::format("{}, {}", lidar.label, agile ? "agile" : "calm");
      const auto marker = agile ? sim::plot::Marker::kTriangle : sim::plot::Marker::kCircle;
      drift.scatter(label, x, drifts, {.color = color / 2, .marker = marker, .marker_px = 4.0});
      off.scatter(label, x, offs, {.color = color / 2, .marker = marker, .marker_px = 4.0});
      ++color;
    }
  }
  experiment.write("slam-drift.svg", figure);
}

}  // namespace

void slam_drift(Experiment& experiment) {
  const int seeds = experiment.repetitions(10, 1);
  std::vector<DriftCase> cases;
  std::vector<sim::Scenario> scenarios;
  for (const DriftWorld& world : kDriftWorlds) {
    if (experiment.quick() && world.costly) continue;
    for (const DriftLidar& lidar : kDriftLidars) {
      for (const bool agile : {false, true}) {
        // A closure needs one round plus two submaps.
        const double way_m = experiment.quick() ? std::max(world.round_m + 45.0, 100.0) : 300.0;
        for (int seed = 1; seed <= seeds; ++seed) {
          cases.push_back({&world, &lidar, agile, static_cast<std::uint64_t>(seed)});
          scenarios.push_back(round_flight(world, lidar, agile, way_m, cases.back().seed));
        }
      }
    }
  }
  std::vector<SlamFlight> flights = fly_on_slam(experiment, std::move(scenarios));
  const DriftFlights all(std::move(cases), std::move(flights));
  write_drift_csv(experiment, all);

  for (const DriftLidar& lidar : kDriftLidars) {
    for (const bool agile : {false, true}) {
      const DriftChoice these = [&](const DriftCase& c) { return c.lidar == &lidar && c.agile == agile; };
      experiment.at_most(
          fmt::format("{}, {}: drift of local SLAM over 50 m [%]", lidar.label, agile ? "agile" : "calm"),
          all.median(these, &SlamFlight::drift_50m_percent), lidar.limit_percent, 2,
          "median; " + all.by_world(these, &SlamFlight::drift_50m_percent, 2));
    }
  }
  for (const DriftLidar& lidar : kDriftLidars) {
    const DriftChoice these = [&](const DriftCase& c) { return c.lidar == &lidar; };
    experiment.at_most(fmt::format("{}: error after closures [m]", lidar.label),
                       all.median(these, &SlamFlight::rms_after_m), 0.08, 2,
                       fmt::format("median of root mean squares; {}; worst {}; by local SLAM alone {}",
                                   all.by_world(these, &SlamFlight::rms_after_m, 2),
                                   short_number(all.worst(these, &SlamFlight::rms_after_m), 2),
                                   short_number(all.median(these, &SlamFlight::rms_local_after_m), 2)));
  }
  for (const DriftLidar& lidar : kDriftLidars) {
    const DriftChoice these = [&](const DriftCase& c) { return c.lidar == &lidar; };
    const double nees = all.median(these, &SlamFlight::nees);
    experiment.row({fmt::format("{}: normalized squared error", lidar.label), short_number(nees, 2),
                    nees >= 2.0 && nees <= 12.0 ? Verdict::kReproduced : Verdict::kDiffers,
                    "median of means over a flight; " + all.by_world(these, &SlamFlight::nees, 2), nees, "2 to 12"});
  }
  const ClosureCount closures = all.closures([](const DriftCase&) { return true; });
  experiment.at_least("closures: precision [%]",
                      100.0 * (closures.closed - closures.false_ones) / std::max(closures.closed, 1), 100.0, 4,
                      fmt::format("{} of {} true, the worst of these off by {:.3f} m",
                                  closures.closed - closures.false_ones, closures.closed, closures.worst_m));
  std::string recalls;
  for (const DriftWorld& world : kDriftWorlds) {
    const ClosureCount c = all.closures([&](const DriftCase& one) { return one.world == &world; });
    if (c.revisits == 0) continue;
    recalls += fmt::format("{}{} {} of {}", recalls.empty() ? "" : ", ", world.scenario, c.revisits_closed, c.revisits);
  }
  for (const DriftLidar& lidar : kDriftLidars) {
    const ClosureCount c = all.closures([&](const DriftCase& one) { return one.lidar == &lidar; });
    recalls += fmt::format("; {} {} of {}", lidar.label, c.revisits_closed, c.revisits);
  }
  experiment.at_least("closures: recall [%]", 100.0 * closures.revisits_closed / std::max(closures.revisits, 1), 95.0,
                      3, recalls);
  int contacts = 0;
  double lost_s = 0.0, way_m = 0.0;
  for (const SlamFlight& f : all.flights()) {
    contacts += f.crashed;
    lost_s += f.lost_s;
    way_m += f.way_m;
  }
  experiment.at_most(
      "contacts", contacts, 0.0, 1,
      fmt::format("{} flights, {:.0f} m, {:.1f} s without a valid estimate", all.flights().size(), way_m, lost_s));
  plot_drift(experiment, all);
}

}  // namespace swiftlet::tools
