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

constexpr DetectorType kDetectorTypes[] = {
    {{"none", "finds nobody", make_module_config<NoDetectorConfig>}, make_no_detector},
    {{"vofod", "flying objects by a multi-state occupancy map [Vrba 2025]", make_module_config<VofodConfig>},
     make_vofod_detector},
    {{"ground_truth", "what a mutual-localization sensor says; an ideal one is added where there is none",
      make_module_config<GroundTruthDetectorConfig>},
     make_ground_truth_detector},
};

}  // namespace

std::span<const DetectorType> detector_types() { return kDetectorTypes; }

std::span<const ModuleType> detector_module_types() { return module_types_of<kDetectorTypes>(); }

std::unique_ptr<Detector> make_detector(const Module& config, const AgentSetup& setup) {
  return row_named(kDetectorTypes, config.type, "detector").make(*config.config, setup);
}

}  // namespace swiftlet
