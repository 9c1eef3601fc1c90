// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "swiftlet/core/planning/uniform_spline.hpp"

namespace swiftlet {

/// Motion limits along a path.
struct PathLimits {
  double speed_mps = 1.0;
  double vertical_speed_mps = 1.0;
  double acceleration_mps2 = 1.0;
  double vertical_acceleration_mps2 = 1.0;
};

/// A timed path. Any frame, the same for all arguments.
struct SplineTrajectory {
  std::vector<Vector3> control_points_m;  ///< control points of a UniformSpline
  double interval_s = 0.2;                ///< [s] between control points; larger values smooth a path more
  double yaw_rad = 0.0;                   ///< heading at the start

  UniformSpline spline() const { return {control_points_m, interval_s}; }
};

/// Converts a polyline into a smooth path with speeds within the limits, from rest to rest. Any frame, the same for all
/// arguments.
/// @param corners_m  at least two
/// @param is_free    test of points on the smoothed path; nullopt when it fails
/// @param least_rounding_m  standard deviation; 0: if no smoothed path is free, corners are kept without a test
std::optional<SplineTrajectory> time_path(const std::vector<Vector3>& corners_m, const PathLimits& limits,
                                          const std::function<bool(const Vector3&)>& is_free,
                                          double least_rounding_m = 0.3);

}  // namespace swiftlet
