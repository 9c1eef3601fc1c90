// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/path_timing.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet {
namespace {

/// [m] spacing of path points at which speeds are computed. Smaller values are slower and more exact.
constexpr double kSpacing_m = 0.1;
/// [m] standard deviations of the rounding of corners, in the order of trial. Larger values fly faster and need more
/// room.
constexpr double kRoundings_m[] = {0.6, 0.3, 0.0};

std::vector<Vector3> dense(const std::vector<Vector3>& corners) {
  std::vector<Vector3> points = {corners.front()};
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Vector3 leg = corners[i] - corners[i - 1];
    const int steps = std::max(1, static_cast<int>(std::ceil(leg.norm() / kSpacing_m)));
    for (int k = 1; k <= steps; ++k) points.push_back(corners[i - 1] + leg * (static_cast<double>(k) / steps));
  }
  return points;
}

// Three moving averages approximate a Gaussian. Beginning and end stay fixed.
std::vector<Vector3> smooth(std::vector<Vector3> points, double sigma_m) {
  const int half = static_cast<int>(std::lround(sigma_m / kSpacing_m));
  const int n = static_cast<int>(points.size());
  for (int pass = 0; pass < 3; ++pass) {
    std::vector<Vector3> averaged = points;
    for (int i = 1; i + 1 < n; ++i) {
      const int reach = std::min({half, i, n - 1 - i});
      Vector3 sum = Vector3::Zero();
      for (int k = -reach; k <= reach; ++k) sum += points[static_cast<std::size_t>(i + k)];
      averaged[static_cast<std::size_t>(i)] = sum / (2 * reach + 1);
    }
    points = std::move(averaged);
  }
  return points;
}

// Speeds within the limits in bends and on slopes, from rest to rest.
std::vector<double> speeds_along(const std::vector<Vector3>& points, const PathLimits& limits) {
  const int n = static_cast<int>(points.size());
  std::vector<double> speed(points.size(), limits.speed_mps), acceleration(points.size(), limits.acceleration_mps2);
  const auto at = [&](int i) { return points[static_cast<std::size_t>(std::clamp(i, 0, n - 1))]; };
  for (int i = 0; i < n; ++i) {
    const Vector3 before = at(i) - at(i - 2), after = at(i + 2) - at(i);
    const double length = 0.5 * (before.norm() + after.norm());
    if (length <= 0.0) continue;
    const Vector3 tangent = (before + after).normalized();
    const Vector3 curvature = (after.normalized() - before.normalized()) / length;
    double& v = speed[static_cast<std::size_t>(i)];
    // On a straight or a level path the quotients are infinite.
    v = std::min(v, std::sqrt(limits.acceleration_mps2 / curvature.head<2>().norm()));
    v = std::min(v, std::sqrt(limits.vertical_acceleration_mps2 / std::abs(curvature.z())));
    v = std::min(v, limits.vertical_speed_mps / std::abs(tangent.z()));
    double& a = acceleration[static_cast<std::size_t>(i)];
    a = std::min(a, limits.vertical_acceleration_mps2 / std::abs(tangent.z()));
  }
  const auto slow_down = [&](std::size_t from, std::size_t to) {
    const double step = (points[to] - points[from]).norm();
    speed[to] = std::min(speed[to], std::sqrt(speed[from] * speed[from] + 2.0 * acceleration[to] * step));
  };
  speed.front() = speed.back() = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) slow_down(i - 1, i);
  for (std::size_t i = points.size() - 1; i > 0; --i) slow_down(i, i - 1);
  return speed;
}

// Resamples the path at equal time intervals.
std::vector<Vector3> at_equal_times(const std::vector<Vector3>& points, const std::vector<double>& speed,
                                    double interval_s) {
  std::vector<Vector3> samples = {points.front()};
  double t = 0.0, next = interval_s;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double step = (points[i] - points[i - 1]).norm();
    const double mean = std::max(0.5 * (speed[i - 1] + speed[i]), 1e-3);
    const double duration = step / mean;
    for (; next <= t + duration && duration > 0.0; next += interval_s) {
      samples.push_back(points[i - 1] + (points[i] - points[i - 1]) * ((next - t) / duration));
    }
    t += duration;
  }
  samples.push_back(points.back());
  return samples;
}

}  // namespace

std::optional<SplineTrajectory> time_path(const std::vector<Vector3>& corners_m, const PathLimits& limits,
                                          const std::function<bool(const Vector3&)>& is_free, double least_rounding_m) {
  const std::vector<Vector3> points = dense(corners_m);
  for (const double sigma_m : kRoundings_m) {
    if (sigma_m < least_rounding_m) break;
    const std::vector<Vector3> smoothed = smooth(points, sigma_m);
    if (sigma_m > 0.0 && !std::all_of(smoothed.begin(), smoothed.end(), is_free)) continue;
    SplineTrajectory path;
    path.control_points_m = at_equal_times(smoothed, speeds_along(smoothed, limits), path.interval_s);
    const Vector3 first_leg = corners_m[1] - corners_m[0];
    path.yaw_rad = elementary::atan2(first_leg.y(), first_leg.x());
    return path;
  }
  return std::nullopt;
}

}  // namespace swiftlet
