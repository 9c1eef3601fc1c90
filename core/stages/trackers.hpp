// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "core/tracking/tracker.hpp"
#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/config.hpp"

namespace swiftlet {

/// One row of core/stages/trackers.cpp.
struct TrackerType {
  ModuleType module;
  std::unique_ptr<Tracker> (*make)(const ModuleConfig& config, const AgentSetup& setup);
  void (*add_needs)(const ModuleConfig& config, AgentNeeds& needs) = nullptr;
};

std::span<const TrackerType> tracker_types();
std::span<const ModuleType> tracker_module_types();
/// Null for `none`. Throws std::invalid_argument on an unknown type.
std::unique_ptr<Tracker> make_tracker(const Module& config, const AgentSetup& setup);
void add_tracker_needs(const Module& config, AgentNeeds& needs);

}  // namespace swiftlet
