// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {

/// External pose measurement in the world. Without noise it is the truth, which bypasses state estimation; with noise
/// it models motion capture or RTK. Noise is white or a stationary Gauss-Markov process (`correlation_time_s`).
struct PoseConfig : SensorConfigOf<PoseConfig> {
  std::string model;
  double rate_hz = 0.0;
  Eigen::Vector3d sigma_position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_rotation_deg = Eigen::Vector3d::Zero();
  double sigma_velocity_mps = 0.0;
  double sigma_rate_radps = 0.0;
  double correlation_time_s = 0.0;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Sensor> make_pose_sensor(const ModuleConfig& config, SensorSetup setup);

}  // namespace swiftlet::sim
