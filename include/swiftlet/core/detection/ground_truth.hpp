// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/detection/detector.hpp"

namespace swiftlet {

/// Bypass of detection: measurements of the vehicle's mutual-localization sensor (Observation::neighbors) as
/// detections. A vehicle without such a sensor gets an ideal one.
struct GroundTruthDetectorConfig : ModuleConfigOf<GroundTruthDetectorConfig> {
  double range_max_m = 100.0;
  double sigma_m = 0.05;
  double latency_s = 0.0;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Detector> make_ground_truth_detector(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
