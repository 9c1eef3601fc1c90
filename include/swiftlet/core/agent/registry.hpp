// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/registry.hpp"

namespace swiftlet {

/// One row of core/agent/registry.cpp.
struct AgentType {
  ModuleType module;
  std::unique_ptr<Agent> (*make)(const ModuleConfig& config, const AgentSetup& setup);
  AgentNeeds (*needs)(const ModuleConfig& config) = nullptr;  ///< null: nothing
  Module* (*guidance)(ModuleConfig& config) = nullptr;        ///< where its guidance is chosen; null: nowhere
};

Registry<AgentType>& agent_registry();
inline std::span<const ModuleType> agent_module_types() { return agent_registry().modules(); }
std::unique_ptr<Agent> make_agent(const Module& config, const AgentSetup& setup);
AgentNeeds needs_of(const Module& agent);
/// Null when guidance of this agent cannot be chosen.
Module* guidance_of(Module& agent);

}  // namespace swiftlet
