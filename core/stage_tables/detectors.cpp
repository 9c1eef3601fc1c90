// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/stage_tables/detectors.hpp"

#include "swiftlet/core/detection/ground_truth.hpp"
#include "swiftlet/core/detection/track_before_detect.hpp"
#include "swiftlet/core/detection/vofod.hpp"

namespace swiftlet {
namespace {

struct NoDetectorConfig : ModuleConfigOf<NoDetectorConfig> {
  void visit(ConfigVisitor&) override {}
};

std::unique_ptr<Detector> make_no_detector(const ModuleConfig&, const AgentSetup&) { return nullptr; }

void need_for_vofod(const ModuleConfig& config, AgentNeeds& needs) {
  const auto& vofod = dynamic_cast<const VofodConfig&>(config);
  needs.detects = true;
  needs.sensors.push_back({"lidar", "detector.type: vofod"});
  needs.prior = vofod.prior;
  needs.prior_voxel_m = vofod.map.voxel_m;
  needs.memory.push_back({"detector.map.size_m", vofod.map_bytes()});
  needs.memory.push_back({"detector.ray_max_m", vofod.ray_window_bytes()});
}

void need_for_track_before_detect(const ModuleConfig& config, AgentNeeds& needs) {
  needs.detects = true;
  needs.sensors.push_back({"lidar", "detector.type: track_before_detect"});
  needs.memory.push_back({"detector.air.size_m", dynamic_cast<const TrackBeforeDetectConfig&>(config).air.bytes()});
}

void need_neighbors_to_detect(const ModuleConfig&, AgentNeeds& needs) { needs.detects = needs.true_neighbors = true; }

constexpr DetectorType kDetectorTypes[] = {
    {{"none", "no detection", make_module_config<NoDetectorConfig>}, make_no_detector, nullptr, ""},
    {{"vofod", "detects flying objects with a multi-state occupancy map [Vrba 2025]", make_module_config<VofodConfig>},
     make_vofod_detector,
     need_for_vofod,
     "voxels.tentative voxels.confident voxels.around clusters detections"},
    {{"track_before_detect",
      "tracks hypotheses of flying objects over many sweeps and reports the probable ones; for targets with few "
      "returns",
      make_module_config<TrackBeforeDetectConfig>},
     make_track_before_detect,
     need_for_track_before_detect,
     "detections"},
    {{"ground_truth", "measurements of a mutual-localization sensor; an ideal sensor is added if the vehicle has none",
      make_module_config<GroundTruthDetectorConfig>},
     make_ground_truth_detector,
     need_neighbors_to_detect,
     ""},
};

}  // namespace

Registry<DetectorType>& detector_registry() {
  static Registry<DetectorType> table("detector", kDetectorTypes);
  return table;
}

std::unique_ptr<Detector> make_detector(const Module& config, const AgentSetup& setup) {
  return detector_registry().make(config, setup);
}

}  // namespace swiftlet
