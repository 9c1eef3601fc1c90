// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "detection_flights.hpp"
#include "experiments.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kOs0Fov_deg = 45.0;
constexpr int kMoving = 0;  // index among the targets of detection_multi

// How often the moving target comes out from behind the wall, and is followed again within 5 s.
struct Recoveries {
  int times = 0, recovered = 0;
};

Recoveries recoveries_of(const std::vector<Sighting>& tracks) {
  constexpr TimeNs kHidden = 1'000'000'000, kPatience = 5'000'000'000;
  Recoveries result;
  TimeNs last_visible = -1, came_out = -1, now = 0;
  bool lost = false;
  for (const Sighting& sighting : tracks) {
    if (sighting.target != kMoving) continue;
    now = sighting.t;
    if (last_visible < 0) last_visible = now;
    if (sighting.visible && now - last_visible > kHidden) {
      came_out = now;
      lost = true;
      ++result.times;
    }
    if (sighting.visible) last_visible = now;
    if (lost && sighting.found && sighting.error_m < kSame_m && now - came_out < kPatience) {
      ++result.recovered;
      lost = false;
    }
  }
  if (lost && now - came_out < kPatience) --result.times;  // the flight ends before the 5 s are over
  return result;
}

struct TrackErrors {
  std::vector<double> m, drifted_m, speed_mps, still_speed_mps, direction_rad;

  void add(const std::vector<Sighting>& tracks) {
    for (const Sighting& s : tracks) {
      if (!s.found || !s.visible) continue;
      m.push_back(s.error_m);
      drifted_m.push_back(s.drifted_error_m);
      (s.target == kMoving ? speed_mps : still_speed_mps).push_back(s.speed_error_mps);
      if (s.target == kMoving) direction_rad.push_back(s.direction_error_rad);
    }
  }
};

int targets_followed(const std::vector<Sighting>& tracks) {
  int followed = 0;
  for (int target = 0; target < 3; ++target) {
    followed += std::any_of(tracks.begin(), tracks.end(),
                            [&](const Sighting& s) { return s.target == target && s.found && s.error_m < kSame_m; });
  }
  return followed;
}

// Fig. 10: trajectories of the targets (lines) and the nearest tracks (crosses) by axis; the background is darker while
// the moving target is hidden.
void draw_axes(Experiment& experiment, const DetectionLog& log, double until_s) {
  sim::plot::Figure figure("Targets (lines) and tracks (crosses) by axis (Fig. 10)", 1);
  figure.set_panel_size(900, 280);
  const char* names[] = {"moving", "still, left", "still, right"};
  for (int axis = 0; axis < 3; ++axis) {
    sim::plot::Panel& panel = figure.add_panel();
    panel.x.label = "time [s]";
    panel.y.label = std::string(1, "xyz"[axis]) + " [m]";
    panel.legend = sim::plot::Legend::kOutside;
    std::array<std::vector<double>, 3> t_s, p_m, track_t_s, track_m;
    std::vector<double> hidden_top, hidden_bottom;
    double least_m = std::numeric_limits<double>::infinity(), most_m = -least_m;
    for (const Sighting& sighting : log.tracks()) {
      if (to_seconds(sighting.t) > until_s) continue;
      const auto target = static_cast<std::size_t>(sighting.target);
      t_s[target].push_back(to_seconds(sighting.t));
      p_m[target].push_back(sighting.p_m[axis]);
      least_m = std::min(least_m, sighting.p_m[axis] - 0.2);
      most_m = std::max(most_m, sighting.p_m[axis] + 0.2);
      if (sighting.found && sighting.error_m < kSame_m && t_s[target].size() % 3 == 0) {
        track_t_s[target].push_back(t_s[target].back());
        track_m[target].push_back(sighting.estimate_m[axis]);
      }
    }
    for (const Sighting& sighting : log.tracks()) {
      if (sighting.target != kMoving || to_seconds(sighting.t) > until_s) continue;
      hidden_bottom.push_back(least_m);
      hidden_top.push_back(sighting.visible ? least_m : most_m);
    }
    panel.band("hidden", t_s[kMoving], hidden_bottom, hidden_top, {.color = 5});
    for (int target = 0; target < 3; ++target) {
      const auto i = static_cast<std::size_t>(target);
      panel.line(names[target], t_s[i], p_m[i], {.color = target, .width_px = 1.2});
      panel.scatter("", track_t_s[i], track_m[i],
                    {.color = target, .marker = sim::plot::Marker::kCross, .marker_px = 2.5});
    }
  }
  experiment.write("detection-multi.svg", figure);
}

/// Track quality over the flights.
struct ThreeTargets {
  int flights = 0;
  int all_followed = 0;  ///< flights in which each target had a track
  int cross_associations = 0;
  /// Appearances of the moving target from behind the wall, and those in which it is followed again within 5 s.
  int came_out = 0, found_again = 0;
  double error_m = 0.0;          ///< mean position error, in the world that the observer believes in
  double drifted_error_m = 0.0;  ///< as error_m, in the true world
  double speed_error_mps = 0.0, still_speed_error_mps = 0.0, direction_error_rad = 0.0;
  double false_tracks_per_min = 0.0;
};

ThreeTargets three_targets_of(const Flights& flights, CsvTable& csv) {
  ThreeTargets sum;
  sum.flights = static_cast<int>(flights.logs.size());
  TrackErrors errors;
  for (std::size_t run = 0; run < flights.logs.size(); ++run) {
    const DetectionLog& log = *flights.logs[run];
    const int followed = targets_followed(log.tracks());
    const Recoveries recoveries = recoveries_of(log.tracks());
    errors.add(log.tracks());
    sum.all_followed += followed == 3;
    sum.cross_associations += log.num_cross_associations();
    sum.came_out += recoveries.times;
    sum.found_again += recoveries.recovered;
    csv.row({static_cast<double>(run + 1), static_cast<double>(followed),
             static_cast<double>(log.num_cross_associations()), static_cast<double>(recoveries.times),
             static_cast<double>(recoveries.recovered), static_cast<double>(log.num_false_tracks())});
  }
  sum.error_m = mean_and_deviation(errors.m).mean;
  sum.drifted_error_m = mean_and_deviation(errors.drifted_m).mean;
  sum.speed_error_mps = mean_and_deviation(errors.speed_mps).mean;
  sum.still_speed_error_mps = mean_and_deviation(errors.still_speed_mps).mean;
  sum.direction_error_rad = mean_and_deviation(errors.direction_rad).mean;
  sum.false_tracks_per_min = 60.0 * flights.false_tracks / flights.observed_s;
  return sum;
}

}  // namespace

/// Three targets in a hall, one of them behind a wall again and again [Vrba 2025, sec. V-B, Figs. 9 and 10].
void detection_multi(Experiment& experiment) {
  std::vector<sim::Scenario> scenarios;
  for (int seed = 1; seed <= experiment.repetitions(20, 2); ++seed) {
    scenarios.push_back(scenario_with("reproduce/detection_multi.yaml", static_cast<std::uint64_t>(seed),
                                      {{"duration_s", experiment.quick() ? "60" : "517"}}));
  }
  const Flights flights = fly_and_log(experiment, scenarios, -kOs0Fov_deg, kOs0Fov_deg, kIgnored_s);
  draw_axes(experiment, *flights.logs.front(), 110.0);
  write_sightings(experiment, "detection-multi", flights);
  CsvTable csv({"seed", "targets_followed", "cross_associations", "came_out", "found_again", "false_tracks"});
  const ThreeTargets sum = three_targets_of(flights, csv);
  experiment.write("detection-multi.csv", csv);
  experiment.claim("runs in which all three targets were followed",
                   fmt::format("{} of {}", sum.all_followed, sum.flights), sum.all_followed == sum.flights);
  experiment.claim("cross-associations", std::to_string(sum.cross_associations), sum.cross_associations == 0);
  experiment.claim("found again after the wall", fmt::format("{} of {}", sum.found_again, sum.came_out),
                   sum.came_out > 0 && sum.found_again == sum.came_out);
  plain_row(experiment, "mean position error of tracks [m]", sum.error_m, 3, "in the world of the observer's odometry");
  plain_row(experiment, "... with the drift of the odometry [m]", sum.drifted_error_m, 3,
            "the document's SLAM comes back to where it was; ours drifts on");
  plain_row(experiment, "speed error, moving target [m/s]", sum.speed_error_mps, 3);
  plain_row(experiment, "speed error, still targets [m/s]", sum.still_speed_error_mps, 3);
  plain_row(experiment, "direction error, moving target [rad]", sum.direction_error_rad, 3);
  plain_row(experiment, "false tracks a minute", sum.false_tracks_per_min, 2);
}

}  // namespace swiftlet::tools
