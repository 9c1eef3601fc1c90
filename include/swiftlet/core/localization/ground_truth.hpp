// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/config.hpp"
#include "swiftlet/core/localization/estimator.hpp"

namespace swiftlet {

/// The pose from outside (Observation::pose), carried to the present by the IMU when it comes more rarely than the
/// tick. A vehicle that was not told its pose learns by the first one where its local frame lies in the world.
struct GroundTruthConfig : ModuleConfigOf<GroundTruthConfig> {
  double timeout_s = 0.5;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<StateEstimator> make_ground_truth_estimator(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
