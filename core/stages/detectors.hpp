// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "core/detection/detector.hpp"
#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/config.hpp"

namespace swiftlet {

/// One row of core/stages/detectors.cpp.
struct DetectorType {
  ModuleType module;
  std::unique_ptr<Detector> (*make)(const ModuleConfig& config, const AgentSetup& setup);
  void (*add_needs)(const ModuleConfig& config, AgentNeeds& needs) = nullptr;
};

std::span<const DetectorType> detector_types();
std::span<const ModuleType> detector_module_types();
/// Null for `none`. Throws std::invalid_argument on an unknown type.
std::unique_ptr<Detector> make_detector(const Module& config, const AgentSetup& setup);
void add_detector_needs(const Module& config, AgentNeeds& needs);

}  // namespace swiftlet
