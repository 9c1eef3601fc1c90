// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/localization/estimator.hpp"

namespace swiftlet {

/// External pose (Observation::pose), propagated to the present by the IMU when its rate is below the tick rate. With
/// an unknown start pose, the first sample determines the pose of the local frame in the world.
struct GroundTruthConfig : ModuleConfigOf<GroundTruthConfig> {
  double timeout_s = 0.5;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<StateEstimator> make_ground_truth_estimator(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
