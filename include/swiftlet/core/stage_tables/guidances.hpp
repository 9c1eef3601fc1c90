// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// Guidance type that a scenario can choose; the list is in core/stage_tables/guidances.cpp.
struct GuidanceType {
  ModuleType module;
  std::unique_ptr<Guidance> (*make)(const ModuleConfig& config, const GuidanceSetup& setup);
  /// Adds the sensors, truth and memory that the stage requires; null: none.
  void (*add_needs)(const ModuleConfig& config, AgentNeeds& needs) = nullptr;
  const char* overlays = nullptr;  ///< names of the overlays, separated by spaces; null: not declared
};

Registry<GuidanceType>& guidance_registry();
inline std::span<const ModuleType> guidance_module_types() { return guidance_registry().modules(); }
/// Makes the guidance of the configured type. Throws std::invalid_argument on an unknown type.
std::unique_ptr<Guidance> make_guidance(const Module& config, const GuidanceSetup& setup);

}  // namespace swiftlet
