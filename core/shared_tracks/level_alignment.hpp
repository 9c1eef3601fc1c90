// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <cmath>

#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/math/angles.hpp"

/// Level alignments of two frames with z up.
namespace swiftlet {

/// Rotation by a heading.
inline Matrix3 turn_about_up(double yaw_rad) {
  const double s = elementary::sin(yaw_rad), c = elementary::cos(yaw_rad);
  return (Matrix3() << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0).finished();
}

/// z x v: derivative of v with respect to a turn about the vertical. Any frame, the same for all arguments.
inline Vector3 up_cross(const Vector3& v) { return {-v.y(), v.x(), 0.0}; }

inline Flown sum_of(const Flown& a, const Flown& b) {
  return {a.path_m + b.path_m, a.turn_rad + b.turn_rad, a.time_s + b.time_s};
}

/// Squared Mahalanobis distance between two alignments about the same anchor.
inline double squared_sigmas_between(const FrameAlignment& a, const FrameAlignment& b) {
  Eigen::Matrix<double, 4, 1> difference;
  difference << a.anchor_local_m - b.anchor_local_m, std::remainder(a.yaw_rad - b.yaw_rad, 2.0 * kPi);
  const FrameAlignment::Covariance S = a.covariance + b.covariance;
  return difference.dot(S.ldlt().solve(difference));
}

}  // namespace swiftlet
