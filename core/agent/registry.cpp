// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/agent/registry.hpp"

#include "core/agent/none.hpp"
#include "swiftlet/core/agent/stack.hpp"

namespace swiftlet {
namespace {

OverlayNames draws_nothing(const ModuleConfig&) { return std::vector<std::string>(); }

constexpr AgentType kAgentTypes[] = {
    {{"stack", "localization, guidance, reference governor and controller", make_module_config<StackConfig>},
     make_stack,
     stack_needs,
     stack_guidance,
     stack_overlays},
    {{"none", "idle motors, no flight", make_module_config<NoneConfig>}, make_none, nullptr, nullptr, draws_nothing},
};

}  // namespace

Registry<AgentType>& agent_registry() {
  static Registry<AgentType> table("agent", kAgentTypes);
  return table;
}

std::unique_ptr<Agent> make_agent(const Module& config, const AgentSetup& setup) {
  return agent_registry().make(config, setup);
}

AgentNeeds needs_of(const Module& agent) {
  const AgentType& row = agent_registry().named(agent.type);
  return row.needs == nullptr ? AgentNeeds() : row.needs(*agent.config);
}

Module* guidance_of(Module& agent) {
  const AgentType& row = agent_registry().named(agent.type);
  return row.guidance == nullptr ? nullptr : row.guidance(*agent.config);
}

OverlayNames overlays_of(const Module& agent) {
  const AgentType& row = agent_registry().named(agent.type);
  return row.overlays == nullptr ? std::nullopt : row.overlays(*agent.config);
}

}  // namespace swiftlet
