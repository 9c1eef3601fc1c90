// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "swiftlet/core/elementary.hpp"
#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// Heading along a horizontal direction; keeps the last one while the direction is too short to tell. Any frame, the
/// same for all arguments.
inline double heading_along(const Vector3& direction, double shortest, double otherwise_rad) {
  if (elementary::hypot(direction.x(), direction.y()) < shortest) return otherwise_rad;
  return elementary::atan2(direction.y(), direction.x());
}

}  // namespace swiftlet
