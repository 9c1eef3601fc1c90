// SPDX-License-Identifier: BSD-3-Clause
#include "core/agent/registry.hpp"

#include "core/agent/none.hpp"
#include "core/agent/stack.hpp"
#include "swiftlet/core/registry.hpp"

namespace swiftlet {
namespace {

constexpr AgentType kAgentTypes[] = {
    {{"stack", "localization, guidance, reference tracker and controller", make_module_config<StackConfig>},
     make_stack},
    {{"none", "motors at idle: a dummy", make_module_config<NoneConfig>}, make_none},
};

}  // namespace

std::span<const AgentType> agent_types() { return kAgentTypes; }

std::span<const ModuleType> agent_module_types() { return module_types_of<kAgentTypes>(); }

std::unique_ptr<Agent> make_agent(const Module& config, const AgentSetup& setup) {
  return row_named(kAgentTypes, config.type, "agent").make(*config.config, setup);
}

}  // namespace swiftlet
