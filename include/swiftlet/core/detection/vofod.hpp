// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/detection/detector.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"

namespace swiftlet {

/// The flying-object detector of Vrba 2025 as three concurrent modules: classification of every scan that it keeps up
/// with, raycasting of the scan with which it starts, and removal of separate background. A module works for its
/// configured latency; the map changes when it is done. N_cls counts the classifications that ended meanwhile.
std::unique_ptr<Detector> make_vofod_detector(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
