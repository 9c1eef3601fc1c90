// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/guidance/rbl_config.hpp"

namespace swiftlet {

std::unique_ptr<Guidance> make_rbl(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
