// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/scan.hpp"

namespace swiftlet {

/// Pseudo-angle: grows monotonically with the azimuth from 0 to 4, without an arc tangent.
inline double turn_of(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  if (sum == 0.0) return 0.0;
  const double part = y / sum;
  return x < 0.0 ? 2.0 - part : (y < 0.0 ? 4.0 + part : part);
}

/// Unit vector of a pseudo-angle in [0, 4) and a height in [-1, 1]: inverse of turn_of().
inline Vector3 direction_at(double turn, double z) {
  const double x = turn < 2.0 ? 1.0 - turn : turn - 3.0;
  const double y = turn < 1.0 ? turn : (turn < 3.0 ? 2.0 - turn : turn - 4.0);
  const double scale = std::sqrt(std::max(1.0 - z * z, 0.0) / (x * x + y * y));
  return {scale * x, scale * y, z};
}

/// Bin of a value in [0, whole) among equal bins; values outside belong to the outermost bins.
inline int bin_in(double value, double whole, int count) {
  return std::clamp(static_cast<int>(value / whole * count), 0, count - 1);
}

/// False for a shot whose direction the driver does not report (BeamTable::directions_lidar).
inline bool has_direction(const BeamTable& beams, int i) { return !beams.directions_lidar[i].isZero(0.0F); }

}  // namespace swiftlet
