// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/localization/estimator.hpp"

namespace swiftlet {

/// State estimation from odometry alone, visual-inertial or any other. The first sample aligns its frame with the
/// vehicle's local frame by position and heading at the start. Both frames have z up. From then on the drift of the
/// odometry is the drift of the estimate. An unknown start heading is taken from the first compass sample, if there is
/// a compass; otherwise the correction stays the identity. The IMU fills the time between samples.
struct OdometryEstimatorConfig : ModuleConfigOf<OdometryEstimatorConfig> {
  double timeout_s = 0.5;
  double position_drift = 0.01;   ///< standard deviation per distance flown
  double yaw_drift_degpm = 0.02;  ///< standard deviation per distance flown

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<StateEstimator> make_odometry_estimator(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
