// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/interception/intercept_config.hpp"

namespace swiftlet {

std::unique_ptr<Guidance> make_intercept(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
