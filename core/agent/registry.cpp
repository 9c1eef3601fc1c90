// SPDX-License-Identifier: BSD-3-Clause
#include "core/agent/registry.hpp"

#include "core/agent/none.hpp"
#include "core/agent/stack.hpp"
#include "swiftlet/core/registry.hpp"

namespace swiftlet {
namespace {

constexpr AgentType kAgentTypes[] = {
    {{"stack", "localization, guidance, reference tracker and controller", make_module_config<StackConfig>},
     make_stack,
     stack_needs,
     stack_guidance},
    {{"none", "motors at idle: a dummy", make_module_config<NoneConfig>}, make_none},
};

}  // namespace

std::span<const AgentType> agent_types() { return kAgentTypes; }

std::span<const ModuleType> agent_module_types() { return module_types_of<kAgentTypes>(); }

std::unique_ptr<Agent> make_agent(const Module& config, const AgentSetup& setup) {
  return row_named(kAgentTypes, config.type, "agent").make(*config.config, setup);
}

AgentNeeds needs_of(const Module& agent) {
  const AgentType& row = row_named(kAgentTypes, agent.type, "agent");
  return row.needs == nullptr ? AgentNeeds() : row.needs(*agent.config);
}

Module* guidance_of(Module& agent) {
  const AgentType& row = row_named(kAgentTypes, agent.type, "agent");
  return row.guidance == nullptr ? nullptr : row.guidance(*agent.config);
}

}  // namespace swiftlet
