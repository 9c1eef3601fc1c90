// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/core/tracking/tracker.hpp"

namespace swiftlet {

/// Tracker type that a scenario can choose; the list is in core/stage_tables/trackers.cpp.
struct TrackerType {
  ModuleType module;
  std::unique_ptr<Tracker> (*make)(const ModuleConfig& config, const AgentSetup& setup);
  /// Adds the sensors, truth and memory that the stage requires; null: none.
  void (*add_needs)(const ModuleConfig& config, AgentNeeds& needs) = nullptr;
};

Registry<TrackerType>& tracker_registry();
inline std::span<const ModuleType> tracker_module_types() { return tracker_registry().modules(); }
/// Null for `none`. Throws std::invalid_argument on an unknown type.
std::unique_ptr<Tracker> make_tracker(const Module& config, const AgentSetup& setup);

}  // namespace swiftlet
