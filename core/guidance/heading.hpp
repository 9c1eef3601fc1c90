// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet {

/// Heading along a horizontal direction; keeps the last one while the direction is too short. Any frame, the same for
/// all arguments.
inline double heading_along(const Vector3& direction, double shortest, double otherwise_rad) {
  if (elementary::hypot(direction.x(), direction.y()) < shortest) return otherwise_rad;
  return elementary::atan2(direction.y(), direction.x());
}

/// Turns a heading along the horizontal velocity of a reference and sets the reference's heading rate. Below
/// `slowest_mps` both are kept.
inline void turn_along_velocity(double slowest_mps, double& yaw_rad, Reference& r) {
  const Vector3 &v = r.velocity_mps, &a = r.acceleration_mps2;
  const double speed_sq = v.head<2>().squaredNorm();
  if (speed_sq < slowest_mps * slowest_mps) return;
  yaw_rad = heading_along(v, 0.0, yaw_rad);
  r.yaw_rate_radps = (v.x() * a.y() - v.y() * a.x()) / speed_sq;
}

}  // namespace swiftlet
