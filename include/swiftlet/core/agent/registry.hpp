// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/registry.hpp"

namespace swiftlet {

using OverlayNames = std::optional<std::vector<std::string>>;

/// Agent type that a scenario can choose; the list is in core/agent/registry.cpp.
struct AgentType {
  ModuleType module;
  std::unique_ptr<Agent> (*make)(const ModuleConfig& config, const AgentSetup& setup);
  AgentNeeds (*needs)(const ModuleConfig& config) = nullptr;  ///< null: no requirements
  Module* (*guidance)(ModuleConfig& config) = nullptr;        ///< the agent's choice of guidance; null: not selectable
  /// Names of all overlays that agents of this kind may draw; nothing: one of the stages does not declare its own.
  /// Null: not declared.
  OverlayNames (*overlays)(const ModuleConfig& config) = nullptr;
};

Registry<AgentType>& agent_registry();
inline std::span<const ModuleType> agent_module_types() { return agent_registry().modules(); }
std::unique_ptr<Agent> make_agent(const Module& config, const AgentSetup& setup);
AgentNeeds needs_of(const Module& agent);
/// Null when the guidance of this agent is not selectable.
Module* guidance_of(Module& agent);
OverlayNames overlays_of(const Module& agent);

}  // namespace swiftlet
