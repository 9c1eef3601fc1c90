// SPDX-License-Identifier: BSD-3-Clause
#include "core/stages/detectors.hpp"

#include "core/detection/ground_truth.hpp"
#include "core/detection/vofod.hpp"
#include "swiftlet/core/registry.hpp"

namespace swiftlet {
namespace {

struct NoDetectorConfig : ModuleConfigOf<NoDetectorConfig> {
  void visit(ConfigVisitor&) override {}
};

std::unique_ptr<Detector> make_no_detector(const ModuleConfig&, const AgentSetup&) { return nullptr; }

void need_for_vofod(const ModuleConfig& config, AgentNeeds& needs) {
  const auto& vofod = dynamic_cast<const VofodConfig&>(config);
  needs.detects = true;
  needs.prior = vofod.prior;
  needs.prior_voxel_m = vofod.map.voxel_m;
  needs.memory.push_back({"detector.map.size_m", vofod.map_bytes()});
  needs.memory.push_back({"detector.ray_max_m", vofod.ray_window_bytes()});
}

void need_neighbors_to_detect(const ModuleConfig&, AgentNeeds& needs) { needs.detects = needs.true_neighbors = true; }

constexpr DetectorType kDetectorTypes[] = {
    {{"none", "finds nobody", make_module_config<NoDetectorConfig>}, make_no_detector},
    {{"vofod", "flying objects by a multi-state occupancy map [Vrba 2025]", make_module_config<VofodConfig>},
     make_vofod_detector,
     need_for_vofod},
    {{"ground_truth", "what a mutual-localization sensor says; an ideal one is added where there is none",
      make_module_config<GroundTruthDetectorConfig>},
     make_ground_truth_detector,
     need_neighbors_to_detect},
};

}  // namespace

std::span<const DetectorType> detector_types() { return kDetectorTypes; }

std::span<const ModuleType> detector_module_types() { return module_types_of<kDetectorTypes>(); }

std::unique_ptr<Detector> make_detector(const Module& config, const AgentSetup& setup) {
  return row_named(kDetectorTypes, config.type, "detector").make(*config.config, setup);
}

void add_detector_needs(const Module& config, AgentNeeds& needs) {
  const DetectorType& row = row_named(kDetectorTypes, config.type, "detector");
  if (row.add_needs != nullptr) row.add_needs(*config.config, needs);
}

}  // namespace swiftlet
