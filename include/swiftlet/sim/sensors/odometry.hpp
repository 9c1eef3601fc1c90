// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {

/// Output of visual-inertial (or LiDAR-inertial) odometry. Its frame has z up and an arbitrary origin and heading, and
/// drifts in position and yaw. Roll and pitch are observable, so they have errors but no drift.
///
/// The drift is a random walk over distance, turning and time. Over a step of length s, turn |dpsi| and time dt:
///   var(yaw)           = yaw_drift^2 s / 100 m + yaw_drift_per_turn^2 |dpsi| / 2 pi + yaw_drift_psqrts^2 dt
///   var(position, 3D)  = (drift_percent/100 * 100 m)^2 s / 100 m + drift_per_turn^2 |dpsi| / 2 pi +
///                        drift_psqrts^2 dt
/// Each axis has a third of the latter, so the drift grows faster at higher speed and turn rate.
struct OdometryConfig : SensorConfigOf<OdometryConfig> {
  std::string model;
  double rate_hz = 30.0;
  enum class Frame { kStart, kWorld, kRandom };
  Frame frame = Frame::kStart;
  double initial_yaw_deg = 180.0;
  double drift_percent = 1.0;
  double drift_per_turn_m = 0.05;
  double drift_m_psqrts = 0.002;
  double yaw_drift_deg = 1.0;
  double yaw_drift_per_turn_deg = 0.5;
  double yaw_drift_deg_psqrts = 0.01;
  double scale_error_percent = 0.2;
  double sigma_position_m = 0.003;
  double sigma_tilt_deg = 0.2;
  double sigma_velocity_mps = 0.03;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Sensor> make_odometry_sensor(const ModuleConfig& config, SensorSetup setup);

}  // namespace swiftlet::sim
