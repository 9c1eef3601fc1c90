// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/uniform_spline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {

UniformSpline::UniformSpline(std::vector<Vector3> control_points_m, double interval_s) : interval_s_(interval_s) {
  ENSURE(!control_points_m.empty() && interval_s > 0.0, control_points_m.size(), interval_s);
  // Triple control points at the ends: the curve is at rest there.
  points_m_.reserve(control_points_m.size() + 4);
  points_m_.assign(2, control_points_m.front());
  points_m_.insert(points_m_.end(), control_points_m.begin(), control_points_m.end());
  points_m_.insert(points_m_.end(), 2, control_points_m.back());
}

double UniformSpline::duration_s() const { return static_cast<double>(points_m_.size() - 3) * interval_s_; }

UniformSpline::State UniformSpline::at(double t_s) const {
  const double place = std::clamp(t_s, 0.0, duration_s()) / interval_s_;
  const std::size_t i = std::min(static_cast<std::size_t>(place), points_m_.size() - 4);
  const double u = place - static_cast<double>(i);
  const double w = 1.0 - u;
  const Vector3 &a = points_m_[i], &b = points_m_[i + 1], &c = points_m_[i + 2], &d = points_m_[i + 3];
  const double h = interval_s_;
  return {
      (w * w * w * a + (3 * u * u * u - 6 * u * u + 4) * b + (3 * w * w * w - 6 * w * w + 4) * c + u * u * u * d) / 6.0,
      (w * w * (b - a) + (w * (1 + u) + u * (2 - u)) * (c - b) + u * u * (d - c)) / (2.0 * h),
      (w * (a - 2 * b + c) + u * (b - 2 * c + d)) / (h * h)};
}

double least_distance_m(const UniformSpline& a, const UniformSpline& b) {
  // [s] Sampling interval; between samples the relative motion counts as straight.
  constexpr double kStep_s = 0.05;
  const double end_s = std::max(a.duration_s(), b.duration_s());
  double least_sq = std::numeric_limits<double>::infinity();
  Vector3 before = a.at(0.0).p_m - b.at(0.0).p_m;
  for (double t_s = kStep_s; t_s < end_s + kStep_s; t_s += kStep_s) {
    // Relative motion between samples is nearly straight: its point of closest approach.
    const Vector3 after = a.at(t_s).p_m - b.at(t_s).p_m;
    const Vector3 motion = after - before;
    const double length_sq = motion.squaredNorm();
    const double s = length_sq > 0.0 ? std::clamp(-before.dot(motion) / length_sq, 0.0, 1.0) : 0.0;
    least_sq = std::min(least_sq, (before + s * motion).squaredNorm());
    before = after;
  }
  return std::sqrt(least_sq);
}

}  // namespace swiftlet
