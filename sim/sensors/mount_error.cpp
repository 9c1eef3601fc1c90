// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/noise.hpp"
#include "swiftlet/sim/sensors/mount_error_config.hpp"

namespace swiftlet::sim {

void MountErrorConfig::visit(ConfigVisitor& v) {
  v.field("position_m", position_m, "[m] displacement of the sensor, body frame");
  v.field("rotation_deg", rotation_deg, "[deg] rotation about the sensor's axes: roll, pitch, yaw");
}

Eigen::Quaterniond MountErrorConfig::applied_to(const Eigen::Quaterniond& R_body_sensor) const {
  return rotation_deg.isZero(0.0) ? R_body_sensor : R_body_sensor * rotation_of_rpy(rotation_deg * kRadPerDeg);
}

Pose MountErrorConfig::applied_to(const Pose& T_body_sensor) const {
  if (position_m.isZero(0.0) && rotation_deg.isZero(0.0)) return T_body_sensor;
  return make_pose(T_body_sensor.translation() + position_m, applied_to(Eigen::Quaterniond(T_body_sensor.linear())));
}

}  // namespace swiftlet::sim
