// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet::sim {

/// Error of a sensor's extrinsic calibration: the true mounting relative to the one known to the agent.
struct MountErrorConfig {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();    ///< displacement, body frame
  Eigen::Vector3d rotation_deg = Eigen::Vector3d::Zero();  ///< roll, pitch, yaw about the sensor's axes: Rz Ry Rx

  void visit(ConfigVisitor& v);
  /// The true mounting of a sensor that is calibrated as T_body_sensor.
  Pose applied_to(const Pose& T_body_sensor) const;
  Eigen::Quaterniond applied_to(const Eigen::Quaterniond& R_body_sensor) const;
};

}  // namespace swiftlet::sim
