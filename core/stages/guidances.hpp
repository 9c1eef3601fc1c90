// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "core/guidance/guidance.hpp"
#include "swiftlet/core/config.hpp"

namespace swiftlet {

/// One row of core/stages/guidances.cpp.
struct GuidanceType {
  ModuleType module;
  std::unique_ptr<Guidance> (*make)(const ModuleConfig& config, const GuidanceSetup& setup);
};

std::span<const GuidanceType> guidance_types();
std::span<const ModuleType> guidance_module_types();
/// Throws std::invalid_argument on an unknown type.
std::unique_ptr<Guidance> make_guidance(const Module& config, const GuidanceSetup& setup);

}  // namespace swiftlet
