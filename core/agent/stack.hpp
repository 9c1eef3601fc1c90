// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "core/control/control_config.hpp"
#include "swiftlet/core/agent.hpp"

namespace swiftlet {

/// The software of one vehicle: localization -> detection -> tracking -> guidance -> reference tracker -> controller.
struct StackConfig : ModuleConfigOf<StackConfig> {
  Module localization;
  Module detector;
  Module tracker;
  Module guidance;
  ControlConfig control;

  StackConfig();
  void visit(ConfigVisitor& v) override;
};

/// Throws std::invalid_argument when the airframe cannot be controlled.
std::unique_ptr<Agent> make_stack(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
