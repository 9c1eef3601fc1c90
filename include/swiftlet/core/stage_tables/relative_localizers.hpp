// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/core/localization/relative_localizer.hpp"

namespace swiftlet {

/// Relative localizer type that a scenario can choose; the list is in core/stage_tables/relative_localizers.cpp.
struct RelativeLocalizerType {
  ModuleType module;
  std::unique_ptr<RelativeLocalizer> (*make)(const ModuleConfig& config, const AgentSetup& setup);
  const char* overlays = nullptr;  ///< names of the overlays, separated by spaces; null: not declared
};

Registry<RelativeLocalizerType>& relative_localizer_registry();
inline std::span<const ModuleType> relative_localizer_module_types() { return relative_localizer_registry().modules(); }
/// Null for `none`. Throws std::invalid_argument on an unknown type or vehicle.
std::unique_ptr<RelativeLocalizer> make_relative_localizer(const Module& config, const AgentSetup& setup);

}  // namespace swiftlet
