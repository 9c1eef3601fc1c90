// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/config.hpp"
#include "swiftlet/core/localization/estimator.hpp"

namespace swiftlet {

/// Odometry alone, visual-inertial or any other. At the first sample its frame is laid onto the vehicle's local frame,
/// once, by position and heading at the start. Both frames have z up. From there its drift is the vehicle's drift. A
/// vehicle that was not told its heading learns it from the first sample of a compass, if it carries one. Otherwise its
/// world stays its local frame. The IMU fills the time between samples.
struct OdometryEstimatorConfig : ModuleConfigOf<OdometryEstimatorConfig> {
  double timeout_s = 0.5;
  double position_drift = 0.01;   ///< sigma by distance flown
  double yaw_drift_degpm = 0.02;  ///< sigma by distance flown

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<StateEstimator> make_odometry_estimator(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
