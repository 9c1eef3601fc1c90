// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "detection_flights.hpp"
#include "experiments.hpp"

namespace swiftlet::tools {
namespace {

struct Latencies {
  const char* name;
  double classification_s, raycasting_s, separation_s;
};
constexpr std::array<Latencies, 3> kLatencies = {
    {{"no latency", 0.0, 0.0, 0.0}, {"a fast computer", 0.05, 0.08, 0.05}, {"Table VI", 0.1123, 0.3195, 0.1596}}};

// Limit of false detections in a forest, at any latency.
constexpr double kMostFalse_per_min = 5.0;

// forest_patrol with sensors on uav1 only.
sim::Scenario flight_with(const Latencies& latencies, bool rolling, std::uint64_t seed, double duration_s) {
  const std::string timing = "vehicles[0].agent.detector.timing.";
  const std::string true_pose = "{type: ground_truth}";
  return scenario_with("forest_patrol.yaml", seed,
                       {{"duration_s", fmt::format("{}", duration_s)},
                        {"recorders", "[]"},
                        {"snapshots", "[]"},
                        {"vehicles[0].sensors[0].rolling", rolling ? "true" : "false"},
                        {timing + "classification_latency_s", fmt::format("{}", latencies.classification_s)},
                        {timing + "raycasting_latency_s", fmt::format("{}", latencies.raycasting_s)},
                        {timing + "separation_latency_s", fmt::format("{}", latencies.separation_s)},
                        {"vehicles[1].sensors", "[]"},
                        {"vehicles[1].agent.localization", true_pose},
                        {"vehicles[2].sensors", "[]"},
                        {"vehicles[2].agent.localization", true_pose},
                        {"vehicles[3].sensors", "[]"}});
}

}  // namespace

// The three modules of the detector modify one map concurrently, so results could depend on their latencies. In a
// forest they must not.
void detection_latencies(Experiment& experiment) {
  const int seeds = experiment.repetitions(20, 1);
  const double duration_s = experiment.quick() ? 4.0 : 12.0;
  std::vector<bool> sweeps = {true};
  if (!experiment.quick()) sweeps.push_back(false);
  CsvTable csv({"case", "recall_visible", "false_detections_per_min", "worst_seed_per_min", "track_recall_visible",
                "false_tracks_per_min"});
  std::vector<sim::Scenario> scenarios;
  for (const bool rolling : sweeps) {
    for (const Latencies& latencies : kLatencies) {
      for (int seed = 1; seed <= seeds; ++seed) {
        scenarios.push_back(flight_with(latencies, rolling, static_cast<std::uint64_t>(seed), duration_s));
      }
    }
  }
  const std::vector<sim::RunSummary> runs = fly(experiment, scenarios);
  const std::string observer = scenarios.front().vehicles.front().name;
  auto first = runs.begin();
  for (const bool rolling : sweeps) {
    for (const Latencies& latencies : kLatencies) {
      const std::vector<sim::RunSummary> of_case(first, first + seeds);
      first += seeds;
      const auto mean = [&](const char* metric) {
        return mean_and_deviation(metric_of(of_case, metric, observer)).mean;
      };
      const std::vector<double> false_per_min = metric_of(of_case, "false_detections_per_min", observer);
      const double worst = *std::max_element(false_per_min.begin(), false_per_min.end());
      const std::string what = fmt::format("{} sweep, {}", rolling ? "rolling" : "frozen", latencies.name);
      experiment.at_most(
          fmt::format("false detections a minute, {}", what), mean("false_detections_per_min"), kMostFalse_per_min, 2,
          fmt::format("recall of what is in view {:.3f}; tracker: recall {:.3f}, {:.1f} false tracks a "
                      "minute",
                      mean("detection_recall_visible"), mean("track_recall_visible"), mean("false_tracks_per_min")));
      csv.row(what, {mean("detection_recall_visible"), mean("false_detections_per_min"), worst,
                     mean("track_recall_visible"), mean("false_tracks_per_min")});
    }
  }
  experiment.write("detection-latencies.csv", csv);
}

}  // namespace swiftlet::tools
