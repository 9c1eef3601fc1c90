// SPDX-License-Identifier: BSD-3-Clause
#include "detection_flights.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "swiftlet/core/uncertainty/error_distribution.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"

namespace swiftlet::tools {
namespace {

double quantile(std::vector<double> samples, double p) {
  std::sort(samples.begin(), samples.end());
  return samples[static_cast<std::size_t>(p * static_cast<double>(samples.size() - 1))];
}

}  // namespace

sim::Scenario agile_flight(const std::string& name, std::uint64_t seed, double duration_s, Overrides overrides) {
  overrides.insert(overrides.begin(), {{"duration_s", fmt::format("{}", duration_s)},
                                       {"vehicles[0].agent.guidance.seed", std::to_string(2 * seed - 1)},
                                       {"vehicles[1].agent.guidance.seed", std::to_string(2 * seed)}});
  return scenario_with("reproduce/" + name + ".yaml", seed, std::move(overrides));
}

Flights fly_and_log(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios, double fov_bottom_deg,
                    double fov_top_deg, double ignored_s, double least_confidence) {
  Flights flights;
  for (const sim::Scenario& scenario : scenarios) {
    flights.logs.push_back(std::make_unique<DetectionLog>(scenario, fov_bottom_deg, fov_top_deg, ignored_s));
    flights.logs.back()->count_from(least_confidence);
  }
  fly(experiment, scenarios,
      {.after_tick = [&](std::size_t run, const sim::Simulation& simulation) { flights.logs[run]->add(simulation); },
       .write = [&](std::size_t run) { return flights.logs[run]->numbers(); },
       .read = [&](std::size_t run, std::span<const double> numbers) { flights.logs[run]->restore(numbers); }});
  std::vector<const std::vector<Sighting>*> detections, tracks;
  for (const auto& log : flights.logs) {
    detections.push_back(&log->detections());
    tracks.push_back(&log->tracks());
    flights.observed_s += log->observed_s();
    flights.false_detections += log->num_false_detections();
    flights.false_tracks += log->num_false_tracks();
  }
  flights.detections = by_distance(detections, kBin_m, kFarthestBin_m);
  flights.tracks = by_distance(tracks, kBin_m, kFarthestBin_m);
  flights.told_tracks = by_distance(tracks, kBin_m, kFarthestBin_m, kTold_s);
  return flights;
}

Curve error_curve(const std::vector<DistanceBin>& bins) {
  Curve curve;
  for (const DistanceBin& bin : bins) {
    if (bin.errors_m.size() < 5) continue;
    curve.x_m.push_back(bin.middle_m());
    curve.y.push_back(bin.mean_error_m());
    curve.low.push_back(quantile(bin.errors_m, 0.25));
    curve.high.push_back(quantile(bin.errors_m, 0.75));
  }
  return curve;
}

Curve recall_curve(const std::vector<DistanceBin>& bins) {
  Curve curve;
  for (const DistanceBin& bin : bins) {
    if (bin.count < 5) continue;
    curve.x_m.push_back(bin.middle_m());
    curve.y.push_back(bin.recall());
  }
  return curve;
}

Curve theory_curve(bool with_noise) {
  Curve curve;
  for (double range_m = 0.0; range_m <= kFarthestBin_m; range_m += 1.0) {
    const Matrix3 Sigma =
        point_covariance(Vector3::UnitX(), range_m, Matrix3::Identity(), MeasurementNoise{}.Sigma_w());
    curve.x_m.push_back(range_m);
    curve.y.push_back(with_noise ? ErrorDistribution(Sigma).mean_m() : 0.0);
  }
  return curve;
}

DistanceBin joined(const std::vector<DistanceBin>& bins, double up_to_m) {
  DistanceBin sum;
  sum.high_m = up_to_m;
  for (const DistanceBin& bin : bins) {
    if (bin.high_m > up_to_m) continue;
    sum.count += bin.count;
    sum.found += bin.found;
    sum.errors_m.insert(sum.errors_m.end(), bin.errors_m.begin(), bin.errors_m.end());
  }
  return sum;
}

void write_sightings(Experiment& experiment, const std::string& name, const Flights& flights) {
  CsvTable csv({"stage", "run", "t_s", "told_s", "target", "range_m", "visible", "points", "found", "error_m", "track",
                "x_m", "y_m", "z_m"});
  for (std::size_t run = 0; run < flights.logs.size(); ++run) {
    const auto write = [&](const char* stage, const std::vector<Sighting>& sightings) {
      for (const Sighting& s : sightings) {
        csv.row(stage,
                {static_cast<double>(run + 1), to_seconds(s.t), to_seconds(s.told), static_cast<double>(s.target),
                 s.range_m, static_cast<double>(s.visible), static_cast<double>(s.points), static_cast<double>(s.found),
                 s.error_m, static_cast<double>(s.track), s.p_m.x(), s.p_m.y(), s.p_m.z()});
      }
    };
    write("detector", flights.logs[run]->detections());
    write("tracker", flights.logs[run]->tracks());
  }
  experiment.write(name + "-sightings.csv", csv);
}

void plain_row(Experiment& experiment, const std::string& what, double value, int digits, const std::string& note) {
  experiment.row({what, short_number(value, digits), Verdict::kNotJudged, note, value});
}

}  // namespace swiftlet::tools
