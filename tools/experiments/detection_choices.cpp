// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <string>
#include <vector>

#include "detection_flights.hpp"
#include "experiments.hpp"

namespace swiftlet::tools {
namespace {

struct Interpretation {
  const char* name;
  const char* key;    // detector setting
  const char* value;  // null: the defaults
};

// Each changes one setting.
constexpr Interpretation kInterpretations[] = {
    {"defaults", nullptr, nullptr},
    {"clustering: voxels", "choices.clustering", "voxels"},
    {"position: box_center", "choices.position", "box_center"},
    {"close_to: confident", "choices.close_to", "confident"},
    {"search: octahedron", "choices.search", "octahedron"},
    {"failed_search: clear", "choices.failed_search", "clear"},
    {"sufficiency: background_ratio", "choices.sufficiency", "background_ratio"},
    {"map_update: before", "choices.map_update", "before"},
    {"ray_end: voxel_before", "choices.ray_end", "voxel_before"},
    {"hit_voxels: keep", "choices.hit_voxels", "keep"},
    {"separate_becomes: free", "choices.separate_becomes", "free"},
    {"separate_reach: sphere", "choices.separate_reach", "sphere"},
    {"cluster_distance_m: 0.25", "cluster_distance_m", "0.25"},
    {"min_points: 1", "min_points", "1"},
};

}  // namespace

void detection_choices(Experiment& experiment) {
  std::vector<sim::Scenario> scenarios;
  for (const Interpretation& interpretation : kInterpretations) {
    Overrides overrides = {{"duration_s", experiment.quick() ? "12" : "30"}};
    if (interpretation.key != nullptr)
      overrides.emplace_back("vehicles[0].agent.detector." + std::string(interpretation.key), interpretation.value);
    scenarios.push_back(scenario_with("reproduce/detection_choices.yaml", 1, overrides));
  }
  const std::vector<sim::RunSummary> runs = fly(experiment, scenarios);
  const std::string observer = scenarios.front().vehicles.front().name;
  const auto metric = [&](const std::string& name) { return metric_of(runs, name, observer); };
  const std::vector<double> recall = metric("detection_recall_visible"), precision = metric("detection_precision"),
                            false_per_min = metric("false_detections_per_min"),
                            error = metric("detection_error_mean_m"), track_recall = metric("track_recall_visible"),
                            false_tracks = metric("false_tracks_per_min");
  CsvTable csv({"interpretation", "recall_visible", "precision", "false_detections_per_min", "error_m",
                "track_recall_visible", "false_tracks_per_min"});
  sim::plot::Figure figure("One interpretation changed at a time", 1);
  figure.set_panel_size(900, 300);
  sim::plot::Panel& panel = figure.add_panel();
  panel.y.label = "share [-]";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    csv.row(kInterpretations[i].name,
            {recall[i], precision[i], false_per_min[i], error[i], track_recall[i], false_tracks[i]});
    panel.x.categories.emplace_back(kInterpretations[i].name);
    experiment.row(
        {kInterpretations[i].name,
         fmt::format("recall {:.3f}, precision {:.3f}, {:.0f} false a minute, error {:.3f} m", recall[i], precision[i],
                     false_per_min[i], error[i]),
         Verdict::kNotJudged,
         fmt::format("tracker: recall {:.3f}, {:.0f} false tracks a minute", track_recall[i], false_tracks[i]),
         recall[i]});
  }
  panel.bars("recall of visible targets", recall).bars("precision", precision);
  panel.legend = sim::plot::Legend::kOutside;
  experiment.write("detection-choices.csv", csv);
  experiment.write("detection-choices.svg", figure);
}

}  // namespace swiftlet::tools
