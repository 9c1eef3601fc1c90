// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/agent.hpp"

namespace swiftlet {

/// No software: rotors at idle. For dummies on the ground.
struct NoneConfig : ModuleConfigOf<NoneConfig> {
  void visit(ConfigVisitor&) override {}
};

std::unique_ptr<Agent> make_none(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
