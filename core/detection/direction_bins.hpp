// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/scan.hpp"

namespace swiftlet {

/// Pseudo-angle of a horizontal direction: increases monotonically with the azimuth, from 0 to 4 for a full turn from
/// the x axis. Cheaper than an arc tangent.
inline double turn_of(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  if (sum == 0.0) return 0.0;
  const double sine = y / sum;  // in the 1-norm
  return x < 0.0 ? 2.0 - sine : (y < 0.0 ? 4.0 + sine : sine);
}

/// Unit vector with a pseudo-angle in [0, 4), see turn_of(), and a z component in [-1, 1].
inline Vector3 direction_at(double turn, double z) {
  const double x = turn < 2.0 ? 1.0 - turn : turn - 3.0;
  const double y = turn < 1.0 ? turn : (turn < 3.0 ? 2.0 - turn : turn - 4.0);
  const double scale = std::sqrt(std::max(1.0 - z * z, 0.0) / (x * x + y * y));
  return {scale * x, scale * y, z};
}

/// Index of the bin of a value, for `count` equal bins over [0, whole). Values outside belong to the outermost bins.
inline int bin_in(double value, double whole, int count) {
  return std::clamp(static_cast<int>(value / whole * count), 0, count - 1);
}

/// False for a beam whose direction the driver does not report, so that BeamTable::directions_lidar is zero there.
inline bool has_direction(const BeamTable& beams, int i) { return !beams.directions_lidar[i].isZero(0.0F); }

}  // namespace swiftlet
