// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/detection/detector.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"

namespace swiftlet {

/// The flying-object detector of Vrba 2025 as three concurrent modules: classification of scans, ray casting, and
/// removal of separate background (small clusters of occupied voxels, as left by an object that has taken off). A
/// module computes for its configured latency, skips the scans that arrive meanwhile, and changes the map at the end.
/// The changes by ray casting and removal have the weight N_cls, the number of classifications that have ended since
/// the rays were cast or since the last removal.
std::unique_ptr<Detector> make_vofod_detector(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
