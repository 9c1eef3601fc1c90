// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "detection_multi.hpp"
#include "experiments.hpp"
#include "gap_flights.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::tools {
namespace {

constexpr std::array<const char*, 2> kPlacedBy = {"stand-in odometry", "SLAM"};

/// Three targets [Vrba 2025, Fig. 10], with an observer on odometry or on SLAM.
void tell_three_targets(Experiment& experiment, int seeds) {
  const double duration_s = experiment.quick() ? 60.0 : 180.0;
  CsvTable csv({"placed_by", "flights", "all_followed", "cross_associations", "came_out", "found_again", "error_m",
                "true_error_m", "speed_error_mps", "direction_error_rad", "false_tracks_per_min"});
  for (const bool slam : {false, true}) {
    Overrides changes;
    if (slam) changes.emplace_back("vehicles[0].agent.localization", "{type: slam}");
    const ThreeTargets f =
        three_targets_of(fly_three_targets(experiment, flights_of_three_targets(seeds, duration_s, changes)));
    const std::string by = kPlacedBy[slam];
    csv.row(by, {static_cast<double>(f.flights), static_cast<double>(f.all_followed),
                 static_cast<double>(f.cross_associations), static_cast<double>(f.came_out),
                 static_cast<double>(f.found_again), f.error_m, f.drifted_error_m, f.speed_error_mps,
                 f.direction_error_rad, f.false_tracks_per_min});
    const std::string note = fmt::format(
        "{} flights of {:.0f} s; in the true world {:.3f} m; speed off by {:.3f} m/s, direction by {:.3f} rad; "
        "{:.2f} false tracks a minute",
        f.flights, duration_s, f.drifted_error_m, f.speed_error_mps, f.direction_error_rad, f.false_tracks_per_min);
    plain_row(experiment, fmt::format("three targets, {}: position error of tracks [m]", by), f.error_m, 3, note);
    const bool as_published =
        f.all_followed == f.flights && f.cross_associations == 0 && f.came_out > 0 && f.found_again == f.came_out;
    experiment.claim(fmt::format("three targets, {}: all followed, none mixed up, found again", by),
                     fmt::format("{} of {}, {}, {} of {}", f.all_followed, f.flights, f.cross_associations,
                                 f.found_again, f.came_out),
                     as_published);
  }
  experiment.write("three-targets.csv", csv);
}

/// The full configuration of a guided vehicle [Pritzl 2024, Fig. 6], with a guide on odometry or on SLAM.
void tell_gap(Experiment& experiment, int seeds) {
  const std::vector<double> distances_m =
      experiment.quick() ? std::vector<double>{0.6} : std::vector<double>{0.25, 0.3, 0.35, 0.4, 0.6};
  GapFlights flights(experiment);
  for (const GapTeam team : {GapTeam::kFull, GapTeam::kFullBySlam}) {
    for (const double safe_distance_m : distances_m) flights.want(team, safe_distance_m, 1, seeds);
  }
  flights.fly_wanted();
  for (const GapTeam team : {GapTeam::kFull, GapTeam::kFullBySlam}) {
    std::string shares;
    int crashes = 0;
    for (const auto& [safe_distance_m, point] : flights.curve(team)) {
      shares +=
          fmt::format("{}{:g}: {}/{}", shares.empty() ? "" : ", ", safe_distance_m, point.successes, point.flights);
      crashes += point.crashes;
    }
    const GapErrors& errors = flights.errors(team);
    const double error_m = errors.count > 0 ? errors.error_sum_m / errors.count : std::nan("");
    plain_row(experiment,
              fmt::format("gap, guide by {}: error of the secondary's place within 1 m of the gap [m]",
                          kPlacedBy[team == GapTeam::kFullBySlam]),
              error_m, 2,
              fmt::format("along the wall {} m; success by safe distance {}; {} contacts",
                          short_number(errors.count > 0 ? errors.along_wall_sum_m / errors.count : std::nan(""), 2),
                          shares, crashes));
    const GapPoint& widest = flights.curve(team).rbegin()->second;
    experiment.at_least(fmt::format("gap, guide by {}: success at a safe distance of 0.6 m [-]",
                                    kPlacedBy[team == GapTeam::kFullBySlam]),
                        widest.share(), 0.9, 2, fmt::format("{} flights", widest.flights));
  }
  experiment.write("gap.csv", flights.csv());
}

}  // namespace

void slam_in_place(Experiment& experiment) {
  tell_three_targets(experiment, experiment.repetitions(5, 1));
  tell_gap(experiment, experiment.repetitions(10, 1));
}

}  // namespace swiftlet::tools
