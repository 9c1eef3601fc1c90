// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "detection_flights.hpp"
#include "experiments.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kNear_m = 40.0;  // sightings up to here are summed up
constexpr int kTarget = 1;        // vehicle

struct Variation {
  const char* name;
  Overrides overrides;
  double fov_bottom_deg = -kOs1Fov_deg, fov_top_deg = kOs1Fov_deg;
};

const std::string kLidar = "vehicles[0].sensors[0]";

// Each changes one thing of the flights of detection_real.yaml.
std::vector<Variation> variations() {
  return {{"as flown: rolling, modelled", {}},
          {"sweep in one instant", {{kLidar + ".rolling", "false"}}},
          {"every return kept", {{kLidar + ".detection.always", "true"}}},
          {"Mid-360",
           {{kLidar,
             "{type: lidar, name: mid360, model: mid360, mount: {position_m: [0, 0, 0.15]}, "
             "told_pose: {enabled: true, sigma_position_m: 0.05, sigma_rotation_rad: 0.005}}"}},
           -7.0,
           52.0},
          {"six blades a propeller", {{"vehicles[1].airframe.propeller_blades", "6"}}}};
}

/// Recall of one target by several observers: found by any, of the scans in which any could see it.
double joint_recall(const std::vector<std::unique_ptr<DetectionLog>>& logs, const std::vector<int>& target_of_log) {
  struct Seen {
    bool visible = false, found = false;
  };
  std::map<TimeNs, Seen> scans;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    for (const Sighting& sighting : logs[k]->detections()) {
      if (sighting.target != target_of_log[k] || sighting.range_m > kNear_m) continue;
      Seen& seen = scans[sighting.t];
      seen.visible |= sighting.visible;
      seen.found |= sighting.visible && sighting.found;
    }
  }
  int visible = 0, found = 0;
  for (const auto& [t, seen] : scans) {
    visible += seen.visible ? 1 : 0;
    found += seen.found ? 1 : 0;
  }
  return visible > 0 ? static_cast<double>(found) / visible : 0.0;
}

void fly_variations(Experiment& experiment, double duration_s) {
  CsvTable csv({"variation", "from_m", "to_m", "sightings", "detector_recall", "detector_error_m", "tracker_recall"});
  sim::plot::Figure figure("What the document could not vary", 2);
  figure.set_panel_size(480, 360);
  sim::plot::Panel &recall = figure.add_panel("Recall of the detector"), &error = figure.add_panel("Position error");
  recall.x.label = error.x.label = "distance [m]";
  recall.y.label = "recall [-]";
  recall.y.min = 0.0;
  recall.y.max = 1.05;
  error.y.label = "mean error [m]";
  error.y.min = 0.0;
  error.legend = sim::plot::Legend::kNone;
  recall.legend = sim::plot::Legend::kAuto;
  int color = 0;
  for (const Variation& variation : variations()) {
    std::vector<sim::Scenario> scenarios;
    for (int seed = 1; seed <= experiment.repetitions(2, 1); ++seed) {
      scenarios.push_back(
          agile_flight("detection_real", static_cast<std::uint64_t>(seed), duration_s, variation.overrides));
    }
    const Flights flights =
        fly_and_log(experiment, scenarios, variation.fov_bottom_deg, variation.fov_top_deg, kIgnored_s);
    const DistanceBin all = joined(flights.detections, kNear_m);
    experiment.row({variation.name, "-", fmt::format("recall {:.3f}, error {:.3f} m", all.recall(), all.mean_error_m()),
                    Verdict::kNotComparable,
                    fmt::format("up to {:g} m, {} sightings; tracker {:.3f}", kNear_m, all.count,
                                joined(flights.told_tracks, kNear_m).recall()),
                    all.recall()});
    const Curve found = recall_curve(flights.detections), errors = error_curve(flights.detections);
    const sim::plot::Style style{.color = color++, .marker = sim::plot::Marker::kCircle};
    recall.line(variation.name, found.x_m, found.y, style);
    error.line(variation.name, errors.x_m, errors.y, style);
    for (std::size_t i = 0; i < flights.detections.size(); ++i) {
      const DistanceBin& bin = flights.detections[i];
      if (bin.count == 0) continue;
      csv.row(variation.name, {bin.low_m, bin.high_m, static_cast<double>(bin.count), bin.recall(), bin.mean_error_m(),
                               flights.told_tracks[i].recall()});
    }
  }
  experiment.write("detection-beyond.csv", csv);
  experiment.write("detection-beyond.svg", figure);
}

void fly_two_observers(Experiment& experiment, double duration_s) {
  const sim::Scenario scenario =
      scenario_with("reproduce/detection_two_observers.yaml", 1, {{"duration_s", fmt::format("{}", duration_s)}});
  std::vector<std::unique_ptr<DetectionLog>> logs;
  std::vector<int> target_of_log;
  for (const std::size_t observer : {0U, 2U}) {
    logs.push_back(std::make_unique<DetectionLog>(scenario, -kOs1Fov_deg, kOs1Fov_deg, kIgnored_s, observer));
    target_of_log.push_back(kTarget - (observer < static_cast<std::size_t>(kTarget) ? 1 : 0));
  }
  fly(experiment, {scenario}, [&](std::size_t, const sim::Simulation& simulation) {
    for (const auto& log : logs) log->add(simulation);
  });
  std::vector<double> alone;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    int visible = 0, found = 0;
    for (const Sighting& sighting : logs[k]->detections()) {
      if (sighting.target != target_of_log[k] || sighting.range_m > kNear_m) continue;
      visible += sighting.visible ? 1 : 0;
      found += sighting.visible && sighting.found ? 1 : 0;
    }
    alone.push_back(visible > 0 ? static_cast<double>(found) / visible : 0.0);
  }
  const double both = joint_recall(logs, target_of_log);
  experiment.row({"two observers: found by either", "-", fmt::format("recall {:.3f}", both), Verdict::kNotComparable,
                  fmt::format("alone {:.3f} and {:.3f}, of what each could see", alone[0], alone[1]), both});
}

}  // namespace

void detection_beyond(Experiment& experiment) {
  const double duration_s = experiment.quick() ? 25.0 : 60.0;
  fly_variations(experiment, duration_s);
  fly_two_observers(experiment, duration_s);
}

}  // namespace swiftlet::tools
