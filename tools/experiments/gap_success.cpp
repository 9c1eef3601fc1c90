// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments.hpp"
#include "gap_flights.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::tools {
namespace {

constexpr std::array kTeams = {GapTeam::kTruthOwnMap, GapTeam::kTruth, GapTeam::kFull, GapTeam::kFullToldOnce,
                               GapTeam::kSingle};

/// Safe distance from which on 90 % succeed, interpolated linearly between two points of the curve.
std::optional<double> distance_of_90(const GapCurve& curve) {
  std::optional<double> found_m;
  const std::pair<const double, GapPoint>* above = nullptr;
  for (auto point = curve.rbegin(); point != curve.rend(); ++point) {
    const double share = point->second.share();
    if (share < 0.9) {
      if (above != nullptr) {
        found_m = point->first + (above->first - point->first) * (0.9 - share) / (above->second.share() - share);
      }
      return found_m;
    }
    above = &*point;
    found_m = point->first;
  }
  return found_m;
}

/// Points of the curve within 0.05 m of the 90 % crossing.
std::vector<double> around_90(const GapCurve& curve) {
  const auto at_m = distance_of_90(curve);
  if (!at_m) return {};
  std::vector<double> near_m;
  for (const auto& [safe_distance_m, point] : curve) {
    if (std::abs(safe_distance_m - *at_m) <= 0.05 + 1e-9) near_m.push_back(safe_distance_m);
  }
  return near_m;
}

void plot(Experiment& experiment, const std::map<GapTeam, GapCurve>& curves) {
  sim::plot::Figure figure("Flights through the gap and back (Fig. 6)", 1);
  figure.set_panel_size(760, 420);
  sim::plot::Panel& panel = figure.add_panel();
  panel.x.label = "safe distance of the planner [m]; the gap is twice as wide and 0.15 m more";
  panel.y.label = "flights that succeeded [%]";
  panel.y.min = 0.0;
  panel.y.max = 100.0;
  for (const auto& [team, curve] : curves) {
    std::vector<double> x, y, low, high;
    for (const auto& [safe_distance_m, point] : curve) {
      const ShareInterval interval = wilson(point.successes, point.flights);
      x.push_back(safe_distance_m);
      y.push_back(100.0 * point.share());
      low.push_back(100.0 * interval.low);
      high.push_back(100.0 * interval.high);
    }
    const int color = static_cast<int>(team);
    panel.band("", x, low, high, {.color = color, .opacity = 0.15});
    panel.line(name_of(team), x, y, {.color = color, .marker = sim::plot::Marker::kCircle});
  }
  experiment.write("gap-success.svg", figure);
}

std::string in_meters(const std::optional<double>& m) { return m ? fmt::format("{:.2f}", *m) : "never"; }

}  // namespace

void gap_success(Experiment& experiment) {
  const int seeds = experiment.repetitions(10, 1);
  std::vector<double> distances_m;
  if (experiment.quick())
    distances_m = {0.2, 0.3, 0.6};
  else
    distances_m = {0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6};
  GapFlights flights(experiment);
  for (const GapTeam team : kTeams) {
    for (const double safe_distance_m : distances_m) flights.want(team, safe_distance_m, 1, seeds);
  }
  flights.fly_wanted();
  if (!experiment.quick()) {
    for (const GapTeam team : kTeams) {
      for (const double safe_distance_m : around_90(flights.curve(team))) {
        flights.want(team, safe_distance_m, seeds + 1, 3 * seeds);
      }
    }
    flights.fly_wanted();
  }

  std::map<GapTeam, std::optional<double>> of_90_m;
  for (const GapTeam team : kTeams) {
    of_90_m[team] = distance_of_90(flights.curve(team));
    std::string shares;
    int crashes = 0;
    for (const auto& [safe_distance_m, point] : flights.curve(team)) {
      shares +=
          fmt::format("{}{:g}: {}/{}", shares.empty() ? "" : ", ", safe_distance_m, point.successes, point.flights);
      crashes += point.crashes;
    }
    experiment.row({fmt::format("{}: safe distance of 90 % success [m]", name_of(team)), in_meters(of_90_m[team]),
                    Verdict::kNotJudged, fmt::format("{}; {} contacts", shares, crashes),
                    of_90_m[team].value_or(std::nan(""))});
  }
  const auto &best_m = of_90_m[GapTeam::kTruthOwnMap], &full_m = of_90_m[GapTeam::kFull],
             &single_m = of_90_m[GapTeam::kSingle];
  if (best_m && full_m) {
    experiment.at_most("full localization, above that of the best [m]", *full_m - *best_m,
                       experiment.published("full localization, above that of the best [m]").value, 2,
                       "true places and the secondary's map");
  }
  if (full_m && single_m) {
    experiment.claim("a UAV is guided through gaps that are too narrow for its guide",
                     fmt::format("{:.2f} m less", *single_m - *full_m), *full_m < *single_m);
  }
  const GapErrors& errors = flights.errors(GapTeam::kFull);
  if (errors.count > 0) {
    experiment.at_most("error of its place within 1 m of the gap [m]", errors.error_sum_m / errors.count,
                       experiment.published("error of its place within 1 m of the gap [m]").value, 2);
    experiment.at_most("the same along the wall [m]", errors.along_wall_sum_m / errors.count,
                       experiment.published("the same along the wall [m]").value, 2);
  }
  experiment.write("flights.csv", flights.csv());
  plot(experiment, flights.curves());
}

}  // namespace swiftlet::tools
