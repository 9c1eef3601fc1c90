// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/detection/detector.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"

namespace swiftlet {

/// The flying-object detector of Vrba 2025 as three modules beside each other. They classify every scan that they can
/// keep up with, cast the rays of the scan with which they start, and remove separate background. A module works for
/// its configured latency; the map changes when it is done. N_cls counts the classifications that ended meanwhile.
std::unique_ptr<Detector> make_vofod_detector(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
