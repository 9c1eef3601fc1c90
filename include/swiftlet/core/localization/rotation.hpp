// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Matrix of the cross product: skew(a) b = a x b. Any frame, the same for all arguments.
inline Matrix3 skew_of(const Vector3& v) {
  Matrix3 m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// Rotation vector of a unit quaternion, at most half a turn long [rad]; the inverse of rotation_by().
inline Vector3 rotation_vector_rad(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const Vector3 v = sign * q.vec();
  const double sine = v.norm(), cosine = sign * q.w();
  if (sine < 1e-6) return 2.0 * v;  // the next term is smaller by a factor of 1e12
  return v * (2.0 * elementary::atan2(sine, cosine) / sine);
}

}  // namespace swiftlet
