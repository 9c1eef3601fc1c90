// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/math/random.hpp"
#include "core/uncertainty/error_distribution.hpp"
#include "core/uncertainty/point_covariance.hpp"
#include "detection_flights.hpp"
#include "experiments.hpp"
#include "parallel.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kBias_m = 0.325;  // circumscribed radius of the published target
constexpr int kFewest = 30;        // sightings of a bin that is judged

// The document flew each case once; a quick version flies a part of it.
Flights fly_agile(const Experiment& experiment, const std::string& name, double full_s,
                  const Overrides& overrides = {}) {
  std::vector<sim::Scenario> scenarios;
  for (int seed = 1; seed <= experiment.repetitions(3, 1); ++seed) {
    scenarios.push_back(
        agile_flight(name, static_cast<std::uint64_t>(seed), experiment.quick() ? 40.0 : full_s, overrides));
  }
  return fly_and_log(experiment, scenarios, -kOs1Fov_deg, kOs1Fov_deg, kIgnored_s);
}

// ---- pictures ------------------------------------------------------------------------------------------------------

// The mean of |bias + noise| with the bias along the ray (towards the sensor) and the noise of eq. (66): a detection is
// the mean of many points of one sweep, whose pose noise they share and whose range noise averages out.
double predicted_error_m(double range_m, double bias_m, const MeasurementNoise& noise) {
  const Matrix3 Sigma = point_covariance(Vector3::UnitX(), range_m, Matrix3::Identity(), noise.Sigma_w());
  const Vector3 sigma = Sigma.diagonal().cwiseSqrt();  // of a ray along x it is diagonal
  const Random random(1, "predicted_error");
  constexpr std::uint32_t kSamples = 20000;
  double sum = 0.0;
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    const auto n = random.normal3(0, i);
    sum += (sigma.cwiseProduct(Vector3(n.data())) - bias_m * Vector3::UnitX()).norm();
  }
  return sum / kSamples;
}

MeasurementNoise noise_of_eq_66() { return {}; }

void draw(Experiment& experiment, const std::string& name, const Flights& flights, bool with_theory) {
  sim::plot::Figure figure("", 2);
  figure.set_panel_size(520, 380);
  sim::plot::Panel& errors = figure.add_panel("Position error (Fig. 11a)");
  errors.x.label = "distance [m]";
  errors.y.label = "error [m]";
  const Curve detected = error_curve(flights.detections), tracked = error_curve(flights.tracks);
  errors.band("", detected.x_m, detected.low, detected.high, {.color = 0});
  errors.line("detector", detected.x_m, detected.y, {.color = 0, .marker = sim::plot::Marker::kCircle});
  errors.line("tracker", tracked.x_m, tracked.y,
              {.color = 1, .dash = sim::plot::Dash::kDashed, .marker = sim::plot::Marker::kSquare});
  std::vector<double> ranges, theory;
  for (double range_m = 0.0; range_m <= kFarthestBin_m; range_m += 1.0) {
    ranges.push_back(range_m);
    const Matrix3 Sigma = point_covariance(Vector3::UnitX(), range_m, Matrix3::Identity(), noise_of_eq_66().Sigma_w());
    theory.push_back(with_theory ? ErrorDistribution(Sigma).mean_m() : 0.0);
  }
  errors.line(with_theory ? "theory: noise alone (Fig. 5)" : "theory: no noise, no error", ranges, theory,
              {.color = 6});
  errors.horizontal("bias of the published target", kBias_m, {.color = 2, .dash = sim::plot::Dash::kDotted});
  sim::plot::Panel& recall = figure.add_panel("Recall (Fig. 11b)");
  recall.x.label = "distance [m]";
  recall.y.label = "recall [-]";
  recall.y.min = 0.0;
  recall.y.max = 1.05;
  const Curve found = recall_curve(flights.detections), followed = recall_curve(flights.tracks);
  recall.line("detector", found.x_m, found.y, {.color = 0, .marker = sim::plot::Marker::kCircle});
  recall.line("tracker", followed.x_m, followed.y,
              {.color = 1, .dash = sim::plot::Dash::kDashed, .marker = sim::plot::Marker::kSquare});
  experiment.write(name + ".svg", figure);

  CsvTable csv({"from_m", "to_m", "sightings", "detector_recall", "detector_error_m", "track_sightings",
                "tracker_recall", "tracker_error_m"});
  for (std::size_t i = 0; i < flights.detections.size(); ++i) {
    const DistanceBin &d = flights.detections[i], &t = flights.tracks[i];
    csv.row({d.low_m, d.high_m, static_cast<double>(d.count), d.recall(), d.mean_error_m(),
             static_cast<double>(t.count), t.recall(), t.mean_error_m()});
  }
  experiment.write(name + ".csv", csv);
}

// ---- sums ----------------------------------------------------------------------------------------------------------

double share_within(const std::vector<double>& errors_m, double limit_m) {
  if (errors_m.empty()) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(std::count_if(errors_m.begin(), errors_m.end(), [&](double e) { return e <= limit_m; })) /
         static_cast<double>(errors_m.size());
}

// Eqs. (69) and (70); false alarms.
void common_rows(Experiment& experiment, const Flights& flights) {
  std::vector<double> speed, direction;
  for (const auto& log : flights.logs) {
    for (const Sighting& sighting : log->tracks()) {
      if (!sighting.found || !sighting.visible) continue;
      speed.push_back(sighting.speed_error_mps);
      direction.push_back(sighting.direction_error_rad);
    }
  }
  plain_row(experiment, "speed error of tracks [m/s]", mean_and_deviation(speed).mean, 3);
  plain_row(experiment, "direction error of tracks [rad]", mean_and_deviation(direction).mean, 3);
  plain_row(experiment, "false detections a minute", 60.0 * flights.false_detections / flights.observed_s, 2);
  plain_row(experiment, "false tracks a minute", 60.0 * flights.false_tracks / flights.observed_s, 2,
            "never within 1 m of a target");
}

}  // namespace

void detection_ideal(Experiment& experiment) {
  const Flights flights = fly_agile(experiment, "detection_ideal", 355.0);
  draw(experiment, "detection-ideal", flights, false);
  const DistanceBin all = joined(flights.detections, kFarthestBin_m),
                    near_detections = joined(flights.detections, 20.0), near_tracks = joined(flights.tracks, 20.0);
  experiment.at_least("share of true positives within the bias of 0.325 m", "all", share_within(all.errors_m, kBias_m),
                      0.99, 4);
  experiment.at_least("recall of the tracker up to 20 m", "1", near_tracks.recall(), 0.95, 3,
                      fmt::format("of targets in view for {:g} s; before, no scan of them can be worked on", kTold_s));
  plain_row(experiment, "recall of the tracker up to 20 m from the first instant",
            joined(flights.tracks, 20.0).recall(), 3);
  plain_row(experiment, "recall of the detector up to 20 m", near_detections.recall(), 3);
  plain_row(experiment, "mean position error of detections [m]", all.mean_error_m(), 3,
            "Table V is missing from the document's text");
  common_rows(experiment, flights);
}

void detection_noisy(Experiment& experiment) {
  const Flights flights = fly_agile(experiment, "detection_noisy", 400.0);
  const Flights ideal = fly_agile(experiment, "detection_ideal", 355.0);
  draw(experiment, "detection-noisy", flights, true);

  CsvTable csv({"middle_m", "samples", "mean_error_m", "bias_m", "predicted_m"});
  double worst = std::numeric_limits<double>::quiet_NaN(), worst_m = 0.0;  // NaN: no distance had enough sightings
  for (std::size_t i = 0; i < flights.detections.size(); ++i) {
    const DistanceBin &noisy = flights.detections[i], &exact = ideal.detections[i];
    if (static_cast<int>(noisy.errors_m.size()) < kFewest || static_cast<int>(exact.errors_m.size()) < kFewest)
      continue;
    MeasurementNoise noise = noise_of_eq_66();
    noise.sigma_range_m = 0.0;  // averages out over the points of a cluster
    const double predicted_m = predicted_error_m(noisy.middle_m(), exact.mean_error_m(), noise);
    csv.row({noisy.middle_m(), static_cast<double>(noisy.errors_m.size()), noisy.mean_error_m(), exact.mean_error_m(),
             predicted_m});
    const double off = std::abs(noisy.mean_error_m() / predicted_m - 1.0);
    if (off <= worst) continue;  // false while nothing was judged
    worst = off;
    worst_m = noisy.middle_m();
  }
  experiment.write("theory.csv", csv);
  experiment.at_most("mean error against theory plus bias, worst distance [share]", "not significantly above", worst,
                     0.20, 2, fmt::format("at {:g} m; the bias is that of the flights without noise", worst_m));
  const DistanceBin detections = joined(flights.detections, kFarthestBin_m),
                    tracks = joined(flights.tracks, kFarthestBin_m);
  experiment.claim("recall of the tracker above the detector's", "yes",
                   fmt::format("{:.3f} against {:.3f}", tracks.recall(), detections.recall()),
                   tracks.recall() >= detections.recall());
  plain_row(experiment, "mean position error of detections [m]", detections.mean_error_m(), 3);
  plain_row(experiment, "mean position error of tracks [m]", tracks.mean_error_m(), 3);
  common_rows(experiment, flights);
}

void detection_real(Experiment& experiment) {
  const Flights flights = fly_agile(experiment, "detection_real", 375.0);
  const Flights kept =
      fly_agile(experiment, "detection_real", 375.0, {{"vehicles[0].sensors[0].detection.always", "true"}});
  draw(experiment, "detection-real", flights, true);
  const double ours = joined(flights.detections, kFarthestBin_m).recall(),
               without = joined(kept.detections, kFarthestBin_m).recall();
  experiment.claim("recall below the simulation in which every return is kept", "overall worse",
                   fmt::format("{:.3f} against {:.3f}", ours, without), ours < without,
                   "the same flights with and without returns lost to reflectivity and range");
  plain_row(experiment, "recall of the tracker", joined(flights.tracks, kFarthestBin_m).recall(), 3);
  plain_row(experiment, "mean position error of detections [m]",
            joined(flights.detections, kFarthestBin_m).mean_error_m(), 3);
  common_rows(experiment, flights);
}

// ---- several targets -----------------------------------------------------------------------------------------------

namespace {

constexpr double kOs0Fov_deg = 45.0;
constexpr int kMoving = 0;  // of the targets of detection_multi

// How often the moving target came out from behind the wall, and how often it was followed again within 5 s.
struct Recoveries {
  int times = 0, recovered = 0;
};

Recoveries recoveries_of(const std::vector<Sighting>& tracks) {
  constexpr TimeNs kHidden = 1'000'000'000, kPatience = 5'000'000'000;
  Recoveries result;
  TimeNs last_visible = 0, came_out = -1;
  bool lost = false;
  for (const Sighting& sighting : tracks) {
    if (sighting.target != kMoving) continue;
    if (sighting.visible && sighting.t - last_visible > kHidden) {
      came_out = sighting.t;
      lost = true;
      ++result.times;
    }
    if (sighting.visible) last_visible = sighting.t;
    if (lost && sighting.found && sighting.error_m < 1.0 && sighting.t - came_out < kPatience) {
      ++result.recovered;
      lost = false;
    }
  }
  return result;
}

void draw_axes(Experiment& experiment, const DetectionLog& log, double until_s) {
  sim::plot::Figure figure("Error of the track nearest to each target (Fig. 10)", 1);
  figure.set_panel_size(900, 240);
  const char* names[] = {"moving target", "still target, left", "still target, right"};
  for (int target = 0; target < 3; ++target) {
    sim::plot::Panel& panel = figure.add_panel(names[target]);
    panel.x.label = "time [s]";
    panel.y.label = "error [m]";
    panel.y.min = 0.0;
    panel.y.max = 1.5;
    std::vector<double> t_s, error_m, hidden_s, hidden;
    for (const Sighting& sighting : log.tracks()) {
      if (sighting.target != target || to_seconds(sighting.t) > until_s) continue;
      t_s.push_back(to_seconds(sighting.t));
      error_m.push_back(sighting.found ? sighting.error_m : std::numeric_limits<double>::quiet_NaN());
      hidden_s.push_back(t_s.back());
      hidden.push_back(sighting.visible ? 0.0 : 1.5);
    }
    panel.band("hidden", hidden_s, std::vector<double>(hidden.size(), 0.0), hidden, {.color = 1});
    panel.line("track", t_s, error_m, {.color = 0});
  }
  experiment.write("detection-multi.svg", figure);
}

}  // namespace

void detection_multi(Experiment& experiment) {
  std::vector<sim::Scenario> scenarios;
  const double duration_s = experiment.quick() ? 60.0 : 517.0;
  for (int seed = 1; seed <= experiment.repetitions(20, 2); ++seed) {
    scenarios.push_back(scenario_with("reproduce/detection_multi.yaml", static_cast<std::uint64_t>(seed),
                                      {{"duration_s", fmt::format("{}", duration_s)}}));
  }
  const Flights flights = fly_and_log(experiment, scenarios, -kOs0Fov_deg, kOs0Fov_deg, kIgnored_s);
  draw_axes(experiment, *flights.logs.front(), 110.0);

  CsvTable csv({"seed", "targets_followed", "cross_associations", "came_out", "found_again", "false_tracks"});
  int all_followed = 0, crossed = 0, came_out = 0, found_again = 0;
  std::vector<double> errors_m;
  for (std::size_t run = 0; run < flights.logs.size(); ++run) {
    const DetectionLog& log = *flights.logs[run];
    int followed = 0;
    for (int target = 0; target < 3; ++target) {
      const auto is_followed = [&](const Sighting& s) { return s.target == target && s.found && s.error_m < 1.0; };
      followed += std::any_of(log.tracks().begin(), log.tracks().end(), is_followed) ? 1 : 0;
    }
    for (const Sighting& sighting : log.tracks()) {
      if (sighting.found && sighting.visible) errors_m.push_back(sighting.error_m);
    }
    const Recoveries recoveries = recoveries_of(log.tracks());
    csv.row({static_cast<double>(run + 1), static_cast<double>(followed),
             static_cast<double>(log.num_cross_associations()), static_cast<double>(recoveries.times),
             static_cast<double>(recoveries.recovered), static_cast<double>(log.num_false_tracks())});
    all_followed += followed == 3 ? 1 : 0;
    crossed += log.num_cross_associations();
    came_out += recoveries.times;
    found_again += recoveries.recovered;
  }
  experiment.write("detection-multi.csv", csv);
  const int runs = static_cast<int>(flights.logs.size());
  experiment.claim("runs in which all three targets were followed", "1 of 1",
                   fmt::format("{} of {}", all_followed, runs), all_followed == runs);
  experiment.claim("cross-associations", "none", std::to_string(crossed), crossed == 0);
  experiment.claim("found again after the wall", "every time", fmt::format("{} of {}", found_again, came_out),
                   came_out > 0 && found_again == came_out);
  plain_row(experiment, "mean position error of tracks [m]", mean_and_deviation(errors_m).mean, 3);
  plain_row(experiment, "false tracks a minute", 60.0 * flights.false_tracks / flights.observed_s, 2);
}

// ---- take-off, hover, landing --------------------------------------------------------------------------------------

void detection_takeoff(Experiment& experiment) {
  std::vector<sim::Scenario> scenarios;
  const int runs = experiment.repetitions(5, 1);
  for (int seed = 1; seed <= runs; ++seed)
    scenarios.push_back(scenario_with("reproduce/detection_takeoff.yaml", static_cast<std::uint64_t>(seed)));
  std::vector<std::vector<double>> heights(scenarios.size());  // by tick, above the start
  std::vector<std::unique_ptr<DetectionLog>> logs;
  for (const sim::Scenario& scenario : scenarios)
    logs.push_back(std::make_unique<DetectionLog>(scenario, -kOs1Fov_deg, kOs1Fov_deg, 0.0));
  fly(experiment, scenarios, [&](std::size_t run, const sim::Simulation& simulation) {
    const double z_m = simulation.view().states[1].p_world_m.z();
    heights[run].push_back(heights[run].empty() ? 0.0
                                                : z_m - simulation.info().scenario->vehicles[1].start.position_m.z());
    logs[run]->add(simulation);
  });

  // High enough that no rule can take it for the ground: d_close and half its size above the lowest place.
  constexpr double kClear_m = 1.5;
  sim::plot::Figure figure("Take-off, hover and landing", 1);
  figure.set_panel_size(800, 300);
  sim::plot::Panel& panel = figure.add_panel();
  panel.x.label = "time [s]";
  panel.y.label = "height [m]";
  std::vector<double> delays_s;
  int up = 0, found_up = 0, never = 0;
  for (std::size_t run = 0; run < logs.size(); ++run) {
    const double tick_s = scenarios[run].tick_s;
    const auto height_at = [&](TimeNs t) {
      const auto tick =
          std::min(static_cast<std::size_t>(std::max(to_seconds(t) / tick_s, 0.0)), heights[run].size() - 1);
      return heights[run][tick] - heights[run][std::min<std::size_t>(1, heights[run].size() - 1)];
    };
    double cleared_s = -1.0, first_s = -1.0;
    std::vector<double> t_s, height_m, seen_s, seen_m;
    for (const Sighting& sighting : logs[run]->tracks()) {
      const double h_m = height_at(sighting.t), now_s = to_seconds(sighting.t);
      t_s.push_back(now_s);
      height_m.push_back(h_m);
      const bool found = sighting.found && sighting.error_m < 1.0;
      if (found) {
        seen_s.push_back(now_s);
        seen_m.push_back(h_m);
      }
      if (h_m < kClear_m) continue;
      if (cleared_s < 0.0) cleared_s = now_s;
      if (found && first_s < 0.0) first_s = now_s;
      ++up;
      found_up += found ? 1 : 0;
    }
    if (first_s < 0.0) {
      ++never;
    } else {
      delays_s.push_back(first_s - cleared_s);
    }
    if (run == 0)
      panel.line("target", t_s, height_m, {.color = 6})
          .scatter("followed", seen_s, seen_m, {.color = 0, .marker_px = 2.0});
  }
  experiment.write("detection-takeoff.svg", figure);
  experiment.claim("targets that took off beside the ground and were found", "-",
                   fmt::format("{} of {}", runs - never, runs), never == 0);
  plain_row(experiment, fmt::format("found after it was {:g} m up [s]", kClear_m), mean_and_deviation(delays_s).mean,
            3);
  experiment.at_least("followed while up (climb, hover, descent) [share]", "-",
                      up == 0 ? 0.0 : static_cast<double>(found_up) / up, 0.8, 3);
}

}  // namespace swiftlet::tools
