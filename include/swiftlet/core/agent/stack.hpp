// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/control/control_config.hpp"
#include "swiftlet/core/detection/detector.hpp"
#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/localization/estimator.hpp"
#include "swiftlet/core/localization/relative_localizer.hpp"
#include "swiftlet/core/mappers/mapper.hpp"
#include "swiftlet/core/tracking/tracker.hpp"

namespace swiftlet {

/// The software of one vehicle: localization -> clouds -> detection -> tracking -> relative localization -> mapping ->
/// guidance -> reference governor -> controller.
struct StackConfig : ModuleConfigOf<StackConfig> {
  Module localization;
  Module detector;
  Module tracker;
  Module relative_localization;
  Module mapping;
  Module guidance;
  ControlConfig control;

  StackConfig();
  void visit(ConfigVisitor& v) override;
};

/// Stages of a stack: made from its configuration, or supplied by the caller.
struct StackStages {
  std::unique_ptr<StateEstimator> localization;
  std::unique_ptr<Detector> detector;                        ///< null: none
  std::unique_ptr<Tracker> tracker;                          ///< null: none
  std::unique_ptr<RelativeLocalizer> relative_localization;  ///< null: none
  std::unique_ptr<Mapper> mapping;                           ///< null: none
  std::unique_ptr<Guidance> guidance;
};

/// Throws std::invalid_argument when the airframe cannot be controlled, or guidance needs a map and there is none.
std::unique_ptr<Agent> make_stack(StackStages stages, const ControlConfig& control, const AgentSetup& setup);

// Functions of the stack's row in the registry.
std::unique_ptr<Agent> make_stack(const ModuleConfig& config, const AgentSetup& setup);
AgentNeeds stack_needs(const ModuleConfig& config);
Module* stack_guidance(ModuleConfig& config);
std::optional<std::vector<std::string>> stack_overlays(const ModuleConfig& config);

}  // namespace swiftlet
