// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/core/localization/estimator.hpp"

namespace swiftlet {

/// State estimator type that a scenario can choose; the list is in core/stage_tables/estimators.cpp.
struct EstimatorType {
  ModuleType module;
  std::unique_ptr<StateEstimator> (*make)(const ModuleConfig& config, const AgentSetup& setup);
  /// Adds the sensors, truth and memory that the stage requires; null: none.
  void (*add_needs)(const ModuleConfig& config, AgentNeeds& needs) = nullptr;
  const char* overlays = nullptr;  ///< names of the overlays, separated by spaces; null: not declared
};

Registry<EstimatorType>& estimator_registry();
inline std::span<const ModuleType> estimator_module_types() { return estimator_registry().modules(); }
/// Throws std::invalid_argument on an unknown type.
std::unique_ptr<StateEstimator> make_estimator(const Module& config, const AgentSetup& setup);

}  // namespace swiftlet
