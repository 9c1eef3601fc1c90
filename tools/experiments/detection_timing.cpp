// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <vector>

#include "detection_flights.hpp"
#include "experiments.hpp"
#include "stopwatch.hpp"
#include "swiftlet/core/detection/vofod_stages.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/tracking/cloud_tracker.hpp"
#include "swiftlet/sim/view/recorder.hpp"

namespace swiftlet::tools {
namespace {

/// Runs the stages of detector and tracker on a flight's scans and times each, outside of the vehicle's stack.
class StageTimer {
 public:
  StageTimer() : registrar_(0.6), stages_(config_of_flight()), tracker_({}, make_kalman_filter({})) {}

  void add(const sim::Simulation& simulation) {
    const sim::TickView& view = simulation.view();
    registrar_.push(view.actions[0]->estimate);
    for (const auto& labeled : view.scans[0]) work_on(std::shared_ptr<const Scan>(labeled, &labeled->scan));
  }

  // In the order of Table VI.
  std::array<Stopwatch, 6> stages;

 private:
  static VofodConfig config_of_flight() {
    VofodConfig config;
    config.map.extent = VoxelMapConfig::Extent::kBounded;
    config.map.center_m = {0.0, 0.0, 6.0};
    config.map.size_m = {130.0, 90.0, 24.0};
    return config;
  }

  void work_on(std::shared_ptr<const Scan> scan) {
    LocalCloud cloud;
    if (!registrar_.make(std::move(scan), cloud)) return;
    std::vector<Detection> detections;
    stages[0].time([&] { stages_.classify(cloud, detections); });
    stages[1].time([&] {
      stages_.cast_rays(cloud);
      stages_.apply_rays(1);
    });
    stages[2].time([&] {
      stages_.find_separate();
      stages_.remove_separate(1);
    });
    const int num_tracks = tracker_.num_tracks();
    Stopwatch all;
    all.time([&] { tracker_.new_cloud(cloud, &stages_.map()); });
    stages[3].add(1e-3 * all.times_ms().front());
    // A detector reports a scan when two newer ones have arrived (0.11 s after it starts, 0.2 s after the scan).
    late_.push_back(std::move(detections));
    if (late_.size() > kScansLate) {
      if (!late_.front().empty()) stages[4].time([&] { tracker_.new_detections(late_.front(), &stages_.map()); });
      late_.pop_front();
    }
    // Cost of a track: the time above minus that of a tracker without tracks.
    CloudTracker idle({}, make_kalman_filter({}));
    Stopwatch without;
    without.time([&] { idle.new_cloud(cloud, &stages_.map()); });
    if (num_tracks > 0) {
      stages[5].add(std::max(0.0, 1e-3 * (all.times_ms().front() - without.times_ms().front())) / num_tracks);
    }
  }

  static constexpr std::size_t kScansLate = 2;

  CloudRegistrar registrar_;
  std::deque<std::vector<Detection>> late_;
  VofodStages stages_;
  CloudTracker tracker_;
};

/// The rows of Table VI and their names in the plot.
struct TimedStage {
  std::string name, short_name;
};
const std::array<TimedStage, 6> kStages = {{{"clustering and classification", "classification"},
                                            {"ray casting", "ray casting"},
                                            {"removal of separate background", "separation"},
                                            {"newPointCloud()", "newPointCloud()"},
                                            {"newDetections()", "newDetections()"},
                                            {"updateTrack()", "updateTrack()"}}};

}  // namespace

void detection_timing(Experiment& experiment) {
  const sim::Scenario scenario =
      agile_flight("detection_noisy", 1, experiment.quick() ? 8.0 : 60.0,
                   {{"vehicles[0].agent.detector", "{type: none}"}, {"vehicles[0].agent.tracker", "{type: none}"}});
  StageTimer timer;
  fly(experiment, {scenario}, [&](std::size_t, const sim::Simulation& simulation) { timer.add(simulation); });

  CsvTable csv({"stage", "mean_ms", "deviation_ms", "maximum_ms", "calls", "published_mean_ms",
                "published_deviation_ms", "published_maximum_ms"});
  std::vector<double> published, ours;
  double together_ms = 0.0, published_together_ms = 0.0;
  sim::plot::Figure figure("Processor time of the stages (Table VI)", 1);
  figure.set_panel_size(760, 320);
  sim::plot::Panel& panel = figure.add_panel();
  for (std::size_t i = 0; i < kStages.size(); ++i) {
    const PublishedFigure& theirs = experiment.published(kStages[i].name + " [ms]");
    const double their_longest_ms = experiment.published(kStages[i].name + ", longest [ms]").value;
    const std::vector<double>& times_ms = timer.stages[i].times_ms();
    const MeanAndDeviation mean = mean_and_deviation(times_ms);
    const double maximum_ms = times_ms.empty() ? 0.0 : *std::max_element(times_ms.begin(), times_ms.end());
    csv.row(kStages[i].name, {mean.mean, mean.deviation, maximum_ms, static_cast<double>(times_ms.size()), theirs.value,
                              theirs.deviation, their_longest_ms});
    experiment.row({theirs.what, fmt::format("{:.2f} ± {:.2f}", mean.mean, mean.deviation),
                    mean.mean < theirs.value ? Verdict::kOtherConditions : Verdict::kDiffers,
                    fmt::format("at most {:.1f} against {:g}; {} calls", maximum_ms, their_longest_ms, times_ms.size()),
                    mean.mean, "at most as long"});
    published.push_back(theirs.value);
    ours.push_back(mean.mean);
    panel.x.categories.push_back(kStages[i].short_name);
    if (i >= 3) continue;  // tracker stages
    together_ms += mean.mean;
    published_together_ms += theirs.value;
  }
  panel.y.label = "time of a call [ms]";
  panel.bars("published", published).bars("ours", ours);
  experiment.write("detection-timing.csv", csv);
  experiment.write("detection-timing.svg", figure);
  experiment.at_most("the three stages of the detector together, a scan [ms]", together_ms, published_together_ms, 3,
                     "one core; published: a Ryzen 3900X of twelve");
}

}  // namespace swiftlet::tools
