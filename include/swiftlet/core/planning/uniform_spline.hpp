// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// A smooth curve over time: the uniform cubic B-spline of its control points. At rest in the first one at t = 0 and in
/// the last one at the end. Velocity and acceleration are continuous; each segment lies in the convex hull of four
/// consecutive control points. Any frame, the same for all arguments.
class UniformSpline {
 public:
  UniformSpline() = default;
  /// @param control_points_m  at least one
  /// @param interval_s        time between consecutive control points
  UniformSpline(std::vector<Vector3> control_points_m, double interval_s);

  struct State {
    Vector3 p_m, v_mps, a_mps2;
  };
  /// Clamped to [0, duration_s()].
  State at(double t_s) const;
  double duration_s() const;

 private:
  std::vector<Vector3> points_m_;
  double interval_s_ = 1.0;
};

/// Smallest distance between the points of two curves at equal times, until the longer one ends [m].
double least_distance_m(const UniformSpline& a, const UniformSpline& b);

}  // namespace swiftlet
