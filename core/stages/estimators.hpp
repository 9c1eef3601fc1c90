// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "core/localization/estimator.hpp"
#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/config.hpp"

namespace swiftlet {

/// One row of core/stages/estimators.cpp.
struct EstimatorType {
  ModuleType module;
  std::unique_ptr<StateEstimator> (*make)(const ModuleConfig& config, const AgentSetup& setup);
  void (*add_needs)(const ModuleConfig& config, AgentNeeds& needs) = nullptr;
};

std::span<const EstimatorType> estimator_types();
std::span<const ModuleType> estimator_module_types();
/// Throws std::invalid_argument on an unknown type.
std::unique_ptr<StateEstimator> make_estimator(const Module& config, const AgentSetup& setup);
void add_estimator_needs(const Module& config, AgentNeeds& needs);

}  // namespace swiftlet
