// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/detection/detector.hpp"
#include "swiftlet/core/detection/track_before_detect_config.hpp"

namespace swiftlet {

/// A detector for targets that return few beams or none in a sweep. Hypotheses are followed through all sweeps. One is
/// told once it is likely enough that it exists (Detection::confidence). It works on one sweep at a time, for its
/// configured latency, and then tells it. Its detections and its tracks have the same order.
std::unique_ptr<Detector> make_track_before_detect(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
