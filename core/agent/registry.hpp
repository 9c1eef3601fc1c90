// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/config.hpp"

namespace swiftlet {

/// One row of core/agent/registry.cpp.
struct AgentType {
  ModuleType module;
  std::unique_ptr<Agent> (*make)(const ModuleConfig& config, const AgentSetup& setup);
};

std::span<const AgentType> agent_types();
std::span<const ModuleType> agent_module_types();
std::unique_ptr<Agent> make_agent(const Module& config, const AgentSetup& setup);

}  // namespace swiftlet
