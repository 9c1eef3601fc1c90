// SPDX-License-Identifier: BSD-3-Clause
#include "core/agent/registry.hpp"

#include <stdexcept>
#include <vector>

#include "core/agent/none.hpp"
#include "core/agent/stack.hpp"

namespace swiftlet {
namespace {

constexpr AgentType kTypes[] = {
    {{"stack", "localization, guidance, reference tracker and controller", make_module_config<StackConfig>},
     make_stack},
    {{"none", "motors at idle: a dummy", make_module_config<NoneConfig>}, make_none},
};

}  // namespace

std::span<const AgentType> agent_types() { return kTypes; }

std::span<const ModuleType> agent_module_types() {
  static const std::vector<ModuleType> modules = [] {
    std::vector<ModuleType> out;
    for (const AgentType& type : kTypes) out.push_back(type.module);
    return out;
  }();
  return modules;
}

std::unique_ptr<Agent> make_agent(const Module& config, const AgentSetup& setup) {
  for (const AgentType& type : kTypes) {
    if (config.type == type.module.name) return type.make(*config.config, setup);
  }
  throw std::invalid_argument("no agent type is named '" + config.type + "'");
}

}  // namespace swiftlet
