// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/guidance/timed_path.hpp"
#include "sim/dataset/dataset_config.hpp"
#include "sim/raycast/ray_scene.hpp"

namespace swiftlet::sim {

/// One vehicle's way, with its times.
struct TimedWay {
  std::vector<Vector3> control_points_m;  ///< of a UniformSpline
  double interval_s = 0.2;
  double yaw_rad = 0.0;  ///< heading at the start

  UniformSpline spline() const { return {control_points_m, interval_s}; }
};

/// Ways for a team through a world, free of collisions with it and with each other. The first vehicle goes from goal to
/// goal at random; the others choose goals at distances from it that cover [partner_min_m, partner_max_m] evenly over
/// the logarithm, mostly where it can see them. A pure function of its arguments.
/// @param radii_m  of the spheres around the vehicles
/// @return one way a vehicle, each of at least `duration_s`; nullopt when none was found
std::optional<std::vector<TimedWay>> plan_flight(const FlightConfig& config,
                                                 const std::shared_ptr<const StaticScene>& world,
                                                 const std::vector<double>& radii_m, double duration_s,
                                                 std::uint64_t seed, int attempt);

/// A polyline as a smooth way with speeds within the limits, from rest to rest.
/// @param free  is the sphere free here? Asked along the smoothed way; nullopt when it is not
std::optional<TimedWay> time_way(const std::vector<Vector3>& corners_m, double speed_mps, const FlightConfig& config,
                                 const std::function<bool(const Vector3&)>& free);

/// Least distance between two ways over their common time [m].
double least_distance_m(const TimedWay& a, const TimedWay& b);

}  // namespace swiftlet::sim
