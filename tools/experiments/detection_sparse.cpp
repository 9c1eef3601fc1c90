// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "detection_flights.hpp"
#include "detection_histories.hpp"
#include "experiments.hpp"
#include "swiftlet/core/uncertainty/error_distribution.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kFarthestSighting_m = 40.0;
constexpr double kExists = 0.5;            // existence probability from which a report counts
constexpr double kLeastTold = 0.02;        // lower threshold, for the reliability curve
constexpr std::uint64_t kFirstSeed = 401;  // nothing is tuned on seeds from here on
constexpr int kReliabilityBins = 10;

enum class Place { kOpen, kForest };

struct Sensor {
  const char* name;
  Place place;
  Overrides overrides;
  double fov_bottom_deg, fov_top_deg;
  bool sees_far;  // adds rows beyond 25 m
};

std::vector<Sensor> sensors() {
  const Overrides mid360 = {{"vehicles[0].sensors[0]", kMid360WithPose}};
  return {{"Mid-360", Place::kOpen, mid360, kMid360Bottom_deg, kMid360Top_deg, false},
          {"OS1-128", Place::kOpen, {}, -kOs1Fov_deg, kOs1Fov_deg, true},
          {"Mid-360 in a forest", Place::kForest, mid360, kMid360Bottom_deg, kMid360Top_deg, false},
          {"OS1-128 in a forest",
           Place::kForest,
           {{"vehicles[0].sensors[0].pattern.columns", "512"}},
           -kOs1Fov_deg,
           kOs1Fov_deg,
           false}};
}

sim::Scenario flight_of(const Sensor& sensor, std::uint64_t seed, double duration_s, Overrides overrides) {
  overrides.insert(overrides.begin(), sensor.overrides.begin(), sensor.overrides.end());
  if (sensor.place == Place::kOpen) return agile_flight("detection_real", seed, duration_s, std::move(overrides));
  overrides.insert(overrides.begin(), {"duration_s", fmt::format("{}", duration_s)});
  return scenario_with("reproduce/detection_forest.yaml", seed, std::move(overrides));
}

double expected_error_m(double range_m) {
  const Matrix3 Sigma = point_covariance(Vector3::UnitX(), range_m, Matrix3::Identity(), MeasurementNoise{}.Sigma_w());
  return ErrorDistribution(Sigma).mean_m();
}

/// Sightings in a range interval.
struct Summary {
  int count = 0, found = 0, found_of_ceiling = 0;
  std::array<int, kWindows_scans.size()> returned{};
  double error_m = 0.0, beyond_noise_m = 0.0;  // means over found targets

  double share(int of) const { return count > 0 ? static_cast<double>(of) / count : std::nan(""); }
  double recall() const { return share(found); }
  /// Recall among the sightings with a return in the last second.
  double recall_of_ceiling() const {
    return returned.back() > 0 ? static_cast<double>(found_of_ceiling) / returned.back() : std::nan("");
  }
};

Summary summary_of(const std::vector<Judged>& all, double from_m, double to_m) {
  Summary s;
  for (const Judged& j : all) {
    if (j.range_m < from_m || j.range_m >= to_m) continue;
    ++s.count;
    for (std::size_t w = 0; w < kWindows_scans.size(); ++w) s.returned[w] += j.returned[w];
    if (!j.found) continue;
    ++s.found;
    s.found_of_ceiling += j.returned.back();
    s.error_m += j.error_m;
    s.beyond_noise_m += j.error_m - expected_error_m(j.range_m);
  }
  s.error_m /= std::max(s.found, 1);
  s.beyond_noise_m /= std::max(s.found, 1);
  return s;
}

/// Results of a detector or tracker over all flights of one sensor.
struct FlownMethod {
  std::string name;
  std::vector<Judged> sightings;
  std::vector<Appearance> appearances;
  int told = 0, false_told = 0, false_tracks = 0, switches = 0;
  double observed_s = 0.0;

  double precision() const { return told > 0 ? 1.0 - static_cast<double>(false_told) / told : std::nan(""); }
  double false_tracks_per_min() const { return 60.0 * false_tracks / observed_s; }
};

/// Delay from coming into view at a range until found.
struct Wait {
  int found = 0, left = 0;  // left: out of view before found
  double mean_s = std::nan("");
};

Wait wait_of(const FlownMethod& method, double from_m, double to_m) {
  Wait wait;
  double sum_s = 0.0;
  for (const Appearance& a : method.appearances) {
    if (a.range_m < from_m || a.range_m >= to_m) continue;
    const bool found = std::isfinite(a.until_found_s);
    ++(found ? wait.found : wait.left);
    if (found) sum_s += a.until_found_s;
  }
  if (wait.found > 0) wait.mean_s = sum_s / wait.found;
  return wait;
}

enum class Part { kDetections, kTracks };

FlownMethod method_of(const std::string& name, const Flights& flights, Part part) {
  FlownMethod method;
  method.name = name;
  method.observed_s = flights.observed_s;
  method.false_tracks = flights.false_tracks;
  for (const auto& log : flights.logs) {
    const bool tracks = part == Part::kTracks;
    const std::vector<Judged> of_flight =
        judged_sightings(tracks ? log->tracks() : log->detections(), kFarthestSighting_m);
    method.sightings.insert(method.sightings.end(), of_flight.begin(), of_flight.end());
    method.told += tracks ? log->num_told_tracks() : log->num_told_detections();
    method.false_told += tracks ? log->num_false_told_tracks() : log->num_false_detections();
    const Histories histories = histories_of(log->tracks());
    method.appearances.insert(method.appearances.end(), histories.appearances.begin(), histories.appearances.end());
    method.switches += histories.switches;
  }
  return method;
}

/// Compares reported existence probabilities with the share of reports that are targets.
void tell_reliability(Experiment& experiment, const std::string& sensor, const Flights& flights, CsvTable& csv,
                      sim::plot::Panel& panel, int color) {
  std::array<double, kReliabilityBins> count{}, told{}, real{};
  for (const auto& log : flights.logs) {
    for (const DetectionLog::Told& t : log->told()) {
      const int bin = std::min(static_cast<int>(t.confidence * kReliabilityBins), kReliabilityBins - 1);
      count[bin] += 1.0;
      told[bin] += t.confidence;
      real[bin] += t.is_target;
    }
  }
  std::vector<double> x, y;
  double difference = 0.0, all = 0.0;
  for (int bin = 0; bin < kReliabilityBins; ++bin) {
    if (count[bin] == 0.0) continue;
    x.push_back(told[bin] / count[bin]);
    y.push_back(real[bin] / count[bin]);
    difference += std::abs(told[bin] - real[bin]);
    all += count[bin];
    csv.row(sensor, {x.back(), y.back(), count[bin]});
  }
  panel.line(sensor, x, y, {.color = color, .marker = sim::plot::Marker::kCircle});
  plain_row(experiment, sensor + ": mean difference between told and true existence", difference / std::max(all, 1.0),
            2, fmt::format("of {:.0f} told", all));
}

void tell_method(Experiment& experiment, const std::string& sensor, const FlownMethod& method) {
  const Summary near = summary_of(method.sightings, 0.0, 25.0), middle = summary_of(method.sightings, 10.0, 25.0);
  const Wait wait = wait_of(method, 0.0, kFarthestSighting_m);
  experiment.row(
      {fmt::format("{}, {}: recall at 10 to 25 m", sensor, method.name),
       fmt::format("{:.3f}, {:.3f} of what returned something in 1 s", middle.recall(), middle.recall_of_ceiling()),
       Verdict::kNotJudged,
       fmt::format("{} sightings; up to 25 m {:.3f}; error {:.3f} m, {:.3f} m beyond the pose's noise; "
                   "precision {:.3f}; {:.2f} false tracks a minute; {} switches; found after {:.2f} s, {} of {} never",
                   middle.count, near.recall(), middle.error_m, middle.beyond_noise_m, method.precision(),
                   method.false_tracks_per_min(), method.switches, wait.mean_s, wait.left, wait.found + wait.left),
       middle.recall()});
}

void tell_far(Experiment& experiment, const std::string& sensor, const FlownMethod& method, double from_m,
              double to_m) {
  const Summary there = summary_of(method.sightings, from_m, to_m);
  const Wait wait = wait_of(method, from_m, to_m);
  plain_row(experiment, fmt::format("{}, {}: recall at {:.0f} to {:.0f} m", sensor, method.name, from_m, to_m),
            there.recall(), 3,
            fmt::format("{} sightings, {:.3f} of what returned something in 1 s; came into view there {} times, "
                        "found after {:.2f} s, {} never",
                        there.count, there.recall_of_ceiling(), wait.found + wait.left, wait.mean_s, wait.left));
}

void compare_on(Experiment& experiment, const Sensor& sensor, CsvTable& csv, sim::plot::Panel& recall,
                CsvTable& reliability_csv, sim::plot::Panel& reliability, int color) {
  std::vector<sim::Scenario> document, fused;
  const bool open = sensor.place == Place::kOpen;
  const int flights = experiment.repetitions(open ? 4 : 2, 1);
  const double duration_s = experiment.quick() ? 20.0 : open ? 60.0 : 45.0;
  for (int k = 0; k < flights; ++k) {
    const std::uint64_t seed = kFirstSeed + static_cast<std::uint64_t>(k);
    document.push_back(flight_of(sensor, seed, duration_s, {}));
    fused.push_back(flight_of(
        sensor, seed, duration_s,
        {{"vehicles[0].agent.detector", fmt::format("{{type: track_before_detect, told_existence: {}}}", kLeastTold)},
         {"vehicles[0].agent.tracker", "{type: detector}"}}));
  }
  const Flights by_document = fly_and_log(experiment, document, sensor.fov_bottom_deg, sensor.fov_top_deg, kIgnored_s);
  const Flights by_fusion =
      fly_and_log(experiment, fused, sensor.fov_bottom_deg, sensor.fov_top_deg, kIgnored_s, kExists);
  const std::array<FlownMethod, 3> methods = {method_of("vofod", by_document, Part::kDetections),
                                              method_of("tracker of vofod", by_document, Part::kTracks),
                                              method_of("track_before_detect", by_fusion, Part::kDetections)};
  for (const FlownMethod& method : methods) tell_method(experiment, sensor.name, method);
  for (const FlownMethod& method : methods) {
    if (!sensor.sees_far) break;
    tell_far(experiment, sensor.name, method, 25.0, 30.0);
    tell_far(experiment, sensor.name, method, 30.0, kFarthestSighting_m);
  }

  std::array<std::vector<double>, 4> curves;  // share with a return in the last second, then recall of each method
  std::vector<double> range_m;
  for (double from_m = 0.0; from_m < kFarthestSighting_m; from_m += kBin_m) {
    const Summary ceiling = summary_of(methods[1].sightings, from_m, from_m + kBin_m);
    if (ceiling.count < 5) continue;
    std::array<Summary, 3> of_method;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      of_method[m] = summary_of(methods[m].sightings, from_m, from_m + kBin_m);
      curves[m + 1].push_back(of_method[m].recall());
    }
    range_m.push_back(from_m + 0.5 * kBin_m);
    curves[0].push_back(ceiling.share(ceiling.returned.back()));
    csv.row(sensor.name,
            {from_m, from_m + kBin_m, static_cast<double>(ceiling.count), ceiling.share(ceiling.returned[0]),
             ceiling.share(ceiling.returned[1]), ceiling.share(ceiling.returned[2]), ceiling.share(ceiling.returned[3]),
             of_method[0].recall(), of_method[1].recall(), of_method[2].recall(), of_method[2].recall_of_ceiling(),
             of_method[2].error_m, of_method[2].beyond_noise_m});
  }
  recall.x.label = "distance [m]";
  recall.y.label = "share of sightings [-]";
  recall.y.min = 0.0;
  recall.y.max = 1.05;
  recall.line("a return in the last second", range_m, curves[0], {.color = 0});
  for (std::size_t m = 0; m < methods.size(); ++m) {
    recall.line(methods[m].name, range_m, curves[m + 1],
                {.color = static_cast<int>(m) + 1, .marker = sim::plot::Marker::kCircle});
  }
  tell_reliability(experiment, sensor.name, by_fusion, reliability_csv, reliability, color);
}

}  // namespace

void detection_sparse(Experiment& experiment) {
  CsvTable csv({"sensor", "from_m", "to_m", "sightings", "return_in_scan", "in_0.3_s", "in_0.5_s", "in_1_s", "vofod",
                "tracker_of_vofod", "track_before_detect", "of_those_with_return_in_1_s", "error_m", "beyond_noise_m"});
  CsvTable reliability_csv({"sensor", "told_existence", "share_of_targets", "told"});
  sim::plot::Figure figure("Sparse returns", 3);
  figure.set_panel_size(420, 340);
  const std::vector<Sensor> all = sensors();
  std::vector<sim::plot::Panel*> panels;
  for (const Sensor& sensor : all) panels.push_back(&figure.add_panel(std::string("Recall, ") + sensor.name));
  sim::plot::Panel& reliability = figure.add_panel("Reliability of the existence");
  reliability.x.label = "told probability [-]";
  reliability.y.label = "share of targets [-]";
  const std::array<double, 2> ends = {0.0, 1.0};
  reliability.line("perfect", ends, ends, {.color = 0});
  for (std::size_t i = 0; i < all.size(); ++i) {
    compare_on(experiment, all[i], csv, *panels[i], reliability_csv, reliability, static_cast<int>(i) + 1);
  }
  experiment.write("detection-sparse.csv", csv);
  experiment.write("detection-sparse-reliability.csv", reliability_csv);
  experiment.write("detection-sparse.svg", figure);
}

}  // namespace swiftlet::tools
