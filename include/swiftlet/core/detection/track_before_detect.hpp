// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/detection/detector.hpp"
#include "swiftlet/core/detection/track_before_detect_config.hpp"

namespace swiftlet {

/// Detector of targets with few or no returns in a sweep. Hypotheses are tracked through all sweeps and reported once
/// they are likely enough to exist (Detection::confidence). Processes one sweep at a time and reports it after the
/// configured latency. Detection i and track i are of the same hypothesis.
std::unique_ptr<Detector> make_track_before_detect(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
