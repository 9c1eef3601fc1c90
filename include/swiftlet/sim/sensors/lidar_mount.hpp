// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {

/// Pose of the sensor on its vehicle: T_body_lidar. On top by default; the view is blocked by all parts of the vehicle
/// except the sensor's own housing.
struct MountConfig {
  Eigen::Vector3d position_m = {0.0, 0.0, 0.15};
  Eigen::Vector3d rpy_deg = Eigen::Vector3d::Zero();  ///< roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll)
  bool clear_of_hull = false;  ///< raises the sensor on its airframe until no beam can meet the hull

  void visit(ConfigVisitor& v);
  Pose T_body_lidar() const;
  /// As T_body_lidar(), raised on this airframe for a sensor with this pattern. Throws std::invalid_argument when no
  /// mast is high enough.
  Pose place_on(const VehicleShape& shape, const Module& pattern) const;
};

}  // namespace swiftlet::sim
