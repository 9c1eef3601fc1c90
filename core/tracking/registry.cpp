// SPDX-License-Identifier: BSD-3-Clause
#include "core/tracking/registry.hpp"

#include <stdexcept>
#include <vector>

#include "core/tracking/trackers.hpp"

namespace swiftlet {
namespace {

constexpr TrackerType kTypes[] = {
    {{"none", "no tracking", make_module_config<NoTrackerConfig>}, make_no_tracker},
    {{"vofod", "follows detections through the LiDAR's clouds with a Kalman filter [Vrba 2025, algorithm 2]",
      make_module_config<VofodTrackerConfig>},
     make_vofod_tracker},
    {{"imm", "the same with interacting multiple models: constant velocity, constant acceleration, coordinated turn",
      make_module_config<ImmTrackerConfig>},
     make_imm_tracker},
    {{"ground_truth", "tracks from the mutual-localization sensor, an ideal one when there is none",
      make_module_config<GroundTruthTrackerConfig>},
     make_ground_truth_tracker},
};

}  // namespace

std::span<const TrackerType> tracker_types() { return kTypes; }

std::span<const ModuleType> tracker_module_types() {
  static const std::vector<ModuleType> modules = [] {
    std::vector<ModuleType> out;
    for (const TrackerType& type : kTypes) out.push_back(type.module);
    return out;
  }();
  return modules;
}

std::unique_ptr<Tracker> make_tracker(const Module& config, const AgentSetup& setup) {
  for (const TrackerType& type : kTypes) {
    if (config.type == type.module.name) return type.make(*config.config, setup);
  }
  throw std::invalid_argument("no tracker type is named '" + config.type + "'");
}

}  // namespace swiftlet
