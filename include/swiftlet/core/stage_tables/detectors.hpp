// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/core/detection/detector.hpp"

namespace swiftlet {

/// Type of detector that scenarios can choose; all are in core/stage_tables/detectors.cpp.
struct DetectorType {
  ModuleType module;
  std::unique_ptr<Detector> (*make)(const ModuleConfig& config, const AgentSetup& setup);
  /// Adds the sensors, truth and memory that the stage requires; null: none.
  void (*add_needs)(const ModuleConfig& config, AgentNeeds& needs) = nullptr;
  const char* overlays = nullptr;  ///< names of the drawn overlays, separated by spaces; null: not declared
};

Registry<DetectorType>& detector_registry();
inline std::span<const ModuleType> detector_module_types() { return detector_registry().modules(); }
/// Detector of the configured type; null for `none`. Throws std::invalid_argument on an unknown type.
std::unique_ptr<Detector> make_detector(const Module& config, const AgentSetup& setup);

}  // namespace swiftlet
