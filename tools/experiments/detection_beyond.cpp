// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "detection_flights.hpp"
#include "experiments.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kNear_m = 40.0;  // range up to which sightings enter the totals
constexpr int kTarget = 1;        // vehicle index

struct Variation {
  const char* name;
  Overrides overrides;
  double fov_bottom_deg = -kOs1Fov_deg, fov_top_deg = kOs1Fov_deg;
};

const std::string kLidar = "vehicles[0].sensors[0]";

// Each differs from detection_real.yaml in one setting.
std::vector<Variation> variations() {
  return {{"as flown", {}},
          {"sweep in one instant", {{kLidar + ".rolling", "false"}}},
          {"every return kept", {{kLidar + ".detection.always", "true"}}},
          {"Mid-360",
           {{kLidar,
             "{type: lidar, name: mid360, model: mid360, mount: {position_m: [0, 0, 0.15]}, "
             "external_pose: {enabled: true, sigma_position_m: 0.05, sigma_rotation_rad: 0.005}}"}},
           -7.0,
           52.0},
          {"six blades a propeller", {{"vehicles[1].airframe.propeller_blades", "6"}}}};
}

/// One target and two observers: among scans in which either could see the target, the shares found by the first, by
/// the second, and by either.
std::array<double, 3> shares_found(const std::array<std::unique_ptr<DetectionLog>, 2>& logs,
                                   const std::array<int, 2>& target_of_log) {
  struct Scan {
    bool visible = false;
    std::array<bool, 2> found{};
  };
  std::map<TimeNs, Scan> scans;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    for (const Sighting& sighting : logs[k]->detections()) {
      if (sighting.target != target_of_log[k] || sighting.range_m > kNear_m) continue;
      Scan& scan = scans[sighting.t];
      scan.visible |= sighting.visible;
      scan.found[k] = sighting.visible && sighting.found;
    }
  }
  double visible = 0.0;
  std::array<double, 3> found{};
  for (const auto& [t, scan] : scans) {
    if (!scan.visible) continue;
    visible += 1.0;
    found[0] += scan.found[0];
    found[1] += scan.found[1];
    found[2] += scan.found[0] || scan.found[1];
  }
  for (double& share : found) share /= std::max(visible, 1.0);
  return found;
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
  error.y.max = 0.45;
  recall.x.max = error.x.max = kNear_m;
  recall.legend = sim::plot::Legend::kNone;  // the panel beside it has the legend
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
    experiment.row({variation.name, fmt::format("recall {:.3f}, error {:.3f} m", all.recall(), all.mean_error_m()),
                    Verdict::kNotJudged,
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
  const Curve theory = theory_curve(true);
  error.line("theory: noise alone (Fig. 5)", theory.x_m, theory.y, {.color = color});
  experiment.write("detection-beyond.csv", csv);
  experiment.write("detection-beyond.svg", figure);
}

void fly_two_observers(Experiment& experiment, double duration_s) {
  const sim::Scenario scenario =
      scenario_with("reproduce/detection_two_observers.yaml", 1, {{"duration_s", fmt::format("{}", duration_s)}});
  std::array<std::unique_ptr<DetectionLog>, 2> logs;
  std::array<int, 2> target_of_log{};
  for (std::size_t k = 0; k < logs.size(); ++k) {
    const std::size_t observer = k == 0 ? 0 : 2;  // vehicles; targets are numbered without the observer
    logs[k] = std::make_unique<DetectionLog>(scenario, -kOs1Fov_deg, kOs1Fov_deg, kIgnored_s, observer);
    target_of_log[k] = kTarget - (observer < static_cast<std::size_t>(kTarget) ? 1 : 0);
  }
  fly(experiment, {scenario}, [&](std::size_t, const sim::Simulation& simulation) {
    for (const auto& log : logs) log->add(simulation);
  });
  const std::array<double, 3> found = shares_found(logs, target_of_log);
  experiment.row({"two observers: found by either", fmt::format("recall {:.3f}", found[2]), Verdict::kNotJudged,
                  fmt::format("by the first {:.3f}, by the second {:.3f}, of the scans in which any could see it",
                              found[0], found[1]),
                  found[2]});
  sim::plot::Figure figure("Two observers, one target", 1);
  figure.set_panel_size(420, 320);
  sim::plot::Panel& panel = figure.add_panel();
  panel.x.categories = {"the first", "the second", "either"};
  panel.y.label = "found in scans that could show it [-]";
  panel.y.min = 0.0;
  panel.y.max = 1.05;
  panel.bars("", {found.begin(), found.end()});
  experiment.write("detection-two-observers.svg", figure);
}

}  // namespace

void detection_beyond(Experiment& experiment) {
  const double duration_s = experiment.quick() ? 25.0 : 60.0;
  fly_variations(experiment, duration_s);
  fly_two_observers(experiment, duration_s);
}

}  // namespace swiftlet::tools
