// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "detection_flights.hpp"
#include "experiments.hpp"
#include "parallel.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"

namespace swiftlet::tools {
namespace {

constexpr int kFewest = 30;          // fewest detections for a bin to be evaluated
constexpr double kCleared_m = 20.0;  // d_max: range up to which rays clear the map

// Largest bias of a detection toward the sensor: it lies on the near side of the target.
double published_bias_m() {
  return find_published("detection-ideal", "bias: circumscribed radius of the target [m]")->value;
}

// The document flies each case once; the quick version is shorter.
Flights fly_agile(Experiment& experiment, const std::string& name, double full_s, const Overrides& overrides = {}) {
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
  const Vector3 sigma = Sigma.diagonal().cwiseSqrt();  // Sigma is diagonal for a ray along x
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

struct Flown {
  const char* name;
  const Flights* flights;
};

// Fig. 11: solid lines are the detector's, dashed ones the tracker's. The band spans the quartiles.
void draw(Experiment& experiment, const std::string& name, const std::vector<Flown>& cases, const Curve& theory,
          const Curve& with_bias = {}) {
  sim::plot::Figure figure("", 2);
  figure.set_panel_size(540, 400);
  sim::plot::Panel& errors = figure.add_panel("Position error (Fig. 11a)");
  errors.x.label = "distance [m]";
  errors.y.label = "error [m]";
  errors.y.min = 0.0;
  sim::plot::Panel& recall = figure.add_panel("Recall (Fig. 11b)");
  recall.x.label = "distance [m]";
  recall.y.label = "recall [-]";
  recall.y.min = 0.0;
  recall.y.max = 1.05;
  int color = 0;
  for (const Flown& flown : cases) {
    const std::string label = cases.size() > 1 ? std::string(", ") + flown.name : std::string();
    const sim::plot::Style solid{.color = color, .marker = sim::plot::Marker::kCircle};
    const sim::plot::Style dashed{
        .color = color, .dash = sim::plot::Dash::kDashed, .marker = sim::plot::Marker::kSquare};
    const Curve detected = error_curve(flown.flights->detections), tracked = error_curve(flown.flights->tracks);
    errors.band("", detected.x_m, detected.low, detected.high, {.color = color});
    errors.line("detector" + label, detected.x_m, detected.y, solid);
    errors.line("tracker" + label, tracked.x_m, tracked.y, dashed);
    const Curve found = recall_curve(flown.flights->detections), followed = recall_curve(flown.flights->tracks);
    recall.line("detector" + label, found.x_m, found.y, solid);
    recall.line("tracker" + label, followed.x_m, followed.y, dashed);
    ++color;
  }
  errors.line("theory: noise alone (Fig. 5)", theory.x_m, theory.y, {.color = 6});
  if (!with_bias.x_m.empty())
    errors.line("theory and bias", with_bias.x_m, with_bias.y, {.color = 6, .marker = sim::plot::Marker::kCross});
  errors.horizontal("bias of the published target", published_bias_m(), {.color = 2, .dash = sim::plot::Dash::kDotted});
  experiment.write(name + ".svg", figure);
}

void write_bins(Experiment& experiment, const std::string& name, const Flights& flights) {
  CsvTable csv({"from_m", "to_m", "sightings", "detector_recall", "detector_error_m", "track_sightings",
                "tracker_recall", "tracker_error_m"});
  for (std::size_t i = 0; i < flights.detections.size(); ++i) {
    const DistanceBin &d = flights.detections[i], &t = flights.tracks[i];
    csv.row({d.low_m, d.high_m, static_cast<double>(d.count), d.recall(), d.mean_error_m(),
             static_cast<double>(t.count), t.recall(), t.mean_error_m()});
  }
  experiment.write(name + ".csv", csv);
}

// ---- rows ----------------------------------------------------------------------------------------------------------

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
  draw(experiment, "detection-ideal", {{"no noise", &flights}}, theory_curve(false));
  write_bins(experiment, "detection-ideal", flights);
  write_sightings(experiment, "detection-ideal", flights);
  const DistanceBin all = joined(flights.detections, kFarthestBin_m),
                    near_detections = joined(flights.detections, kCleared_m),
                    near_tracks = joined(flights.tracks, kCleared_m),
                    all_tracks = joined(flights.tracks, kFarthestBin_m);
  experiment.at_least("share of true positives within the bias of 0.325 m",
                      share_within(all.errors_m, published_bias_m()), 0.99, 4,
                      fmt::format("{} detections", all.errors_m.size()));
  experiment.at_least("recall of the tracker up to 20 m", near_tracks.recall(), 0.95, 3,
                      fmt::format("{} scans, from the first in which the target is in view", near_tracks.count));
  plain_row(experiment, "recall of the detector up to 20 m", near_detections.recall(), 3);
  plain_row(experiment, "recall of the tracker, all distances", all_tracks.recall(), 3);
  plain_row(experiment, "recall of the detector, all distances", all.recall(), 3);
  plain_row(experiment, "mean position error of detections [m]", all.mean_error_m(), 3,
            "Table V is missing from the document's text");
  plain_row(experiment, "mean position error of tracks [m]", all_tracks.mean_error_m(), 3);
  common_rows(experiment, flights);
}

void detection_noisy(Experiment& experiment) {
  const Flights flights = fly_agile(experiment, "detection_noisy", 400.0);
  const Flights ideal = fly_agile(experiment, "detection_ideal", 355.0);

  CsvTable csv({"middle_m", "samples", "mean_error_m", "bias_m", "predicted_m"});
  double worst = std::numeric_limits<double>::quiet_NaN(), worst_m = 0.0;  // NaN: no distance had enough sightings
  int judged = 0;
  Curve predicted;
  for (std::size_t i = 0; i < flights.detections.size(); ++i) {
    const DistanceBin &noisy = flights.detections[i], &exact = ideal.detections[i];
    if (static_cast<int>(noisy.errors_m.size()) < kFewest || static_cast<int>(exact.errors_m.size()) < kFewest)
      continue;
    MeasurementNoise noise = noise_of_eq_66();
    noise.sigma_range_m = 0.0;  // averages out over the points of a cluster
    const double predicted_m = predicted_error_m(noisy.middle_m(), exact.mean_error_m(), noise);
    predicted.x_m.push_back(noisy.middle_m());
    predicted.y.push_back(predicted_m);
    csv.row({noisy.middle_m(), static_cast<double>(noisy.errors_m.size()), noisy.mean_error_m(), exact.mean_error_m(),
             predicted_m});
    ++judged;
    const double off = std::abs(noisy.mean_error_m() / predicted_m - 1.0);
    if (off <= worst) continue;  // false while worst is NaN
    worst = off;
    worst_m = noisy.middle_m();
  }
  draw(experiment, "detection-noisy", {{"noise", &flights}, {"no noise", &ideal}}, theory_curve(true), predicted);
  write_bins(experiment, "detection-noisy", flights);
  write_sightings(experiment, "detection-noisy", flights);
  experiment.write("theory.csv", csv);
  experiment.at_most(
      "mean error against theory plus bias, worst distance [share]", worst, 0.20, 2,
      fmt::format(
          "at {:g} m, of {} distances with {} detections or more; the bias is that of the flights without noise",
          worst_m, judged, kFewest));
  const DistanceBin detections = joined(flights.detections, kFarthestBin_m),
                    tracks = joined(flights.tracks, kFarthestBin_m);
  experiment.claim("recall of the tracker above the detector's",
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
  draw(experiment, "detection-real", {{"modeled returns", &flights}, {"every return kept", &kept}}, theory_curve(true));
  write_bins(experiment, "detection-real", flights);
  write_bins(experiment, "detection-real-kept", kept);
  const double ours = joined(flights.detections, kFarthestBin_m).recall(),
               without = joined(kept.detections, kFarthestBin_m).recall();
  experiment.claim("recall below the simulation in which every return is kept",
                   fmt::format("{:.3f} against {:.3f}", ours, without), ours < without,
                   "the same flights with and without returns lost to reflectivity and range");
  plain_row(experiment, "recall of the tracker", joined(flights.tracks, kFarthestBin_m).recall(), 3);
  plain_row(experiment, "mean position error of detections [m]",
            joined(flights.detections, kFarthestBin_m).mean_error_m(), 3);
  common_rows(experiment, flights);
}

}  // namespace swiftlet::tools
