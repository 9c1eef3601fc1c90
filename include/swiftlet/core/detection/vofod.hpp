// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/detection/detector.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"

namespace swiftlet {

/// The flying-object detector of Vrba 2025 as three concurrent modules: classification of scans, ray casting, and
/// removal of separate background. A module takes its configured latency and skips the scans that arrive meanwhile; the
/// map changes at the end. N_cls counts the classifications that ended meanwhile.
std::unique_ptr<Detector> make_vofod_detector(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
