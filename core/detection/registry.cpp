// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/registry.hpp"

#include <stdexcept>
#include <vector>

#include "core/detection/ground_truth.hpp"
#include "core/detection/vofod.hpp"

namespace swiftlet {
namespace {

struct NoDetectorConfig : ModuleConfigOf<NoDetectorConfig> {
  void visit(ConfigVisitor&) override {}
};

std::unique_ptr<Detector> make_no_detector(const ModuleConfig&, const AgentSetup&) { return nullptr; }

constexpr DetectorType kTypes[] = {
    {{"none", "finds nobody", make_module_config<NoDetectorConfig>}, make_no_detector},
    {{"vofod", "flying objects by a multi-state occupancy map [Vrba 2025]", make_module_config<VofodConfig>},
     make_vofod_detector},
    {{"ground_truth", "what a mutual-localization sensor says; an ideal one is added where there is none",
      make_module_config<GroundTruthDetectorConfig>},
     make_ground_truth_detector},
};

}  // namespace

std::span<const DetectorType> detector_types() { return kTypes; }

std::span<const ModuleType> detector_module_types() {
  static const std::vector<ModuleType> modules = [] {
    std::vector<ModuleType> out;
    for (const DetectorType& type : kTypes) out.push_back(type.module);
    return out;
  }();
  return modules;
}

std::unique_ptr<Detector> make_detector(const Module& config, const AgentSetup& setup) {
  for (const DetectorType& type : kTypes) {
    if (config.type == type.module.name) return type.make(*config.config, setup);
  }
  throw std::invalid_argument("no detector type is named '" + config.type + "'");
}

}  // namespace swiftlet
