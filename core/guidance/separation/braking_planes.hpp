// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/guidance/half_space.hpp"
#include "swiftlet/core/control/motion_limits.hpp"

namespace swiftlet {

/// Braking path of a vehicle: the segment from its position to its stopping point.
struct Braking {
  Vector3 p_local_m = Vector3::Zero();
  Vector3 stop_local_m = Vector3::Zero();  ///< stopping point
};

/// @param reaction_s  delay before the braking begins
Braking braking_of(const Vector3& p_local_m, const Vector3& v_local_mps, double reaction_s, const MotionLimits& limits);

/// Plane halfway between the nearest points of two braking paths.
///
/// Two vehicles that keep their braking paths on their own sides of such planes can still stop there. So their distance
/// stays above `distance_m` as far as the braking paths are accurate. Heights are scaled by `distance_m / vertical_m`,
/// because of the downwash of the rotors.
/// @param uncertainty_m  uncertainty of the other's position; reduces the room to advance, but never forces a retreat
/// @return relative to the position of `self`
HalfSpace braking_plane(const Braking& self, const Braking& other, double distance_m, double vertical_m,
                        double uncertainty_m);

/// Half-space within which the vehicle stays until its next sighting of the other: a share of the gap at the last
/// sighting.
///
/// When both vehicles use less than half, they stay apart for any motion within their half-spaces and any interval.
/// No knowledge of speeds is required.
/// @param uncertainty_m  uncertainty of the other's position at the last sighting
/// @return relative to `p_local_m`, the present position of the vehicle
HalfSpace pledge_plane(const Vector3& own_seen_local_m, const Vector3& other_seen_local_m, const Vector3& p_local_m,
                       double distance_m, double vertical_m, double uncertainty_m, double share);

/// Half-space beside the path of another vehicle that continues straight, which would overtake a vehicle that only
/// retreats.
///
/// The side is that of the vehicle, or the right side seen in flight direction of the other vehicle. The evasion is
/// level, or vertical where that is faster.
/// @return relative to the position of `self`; nothing when the other does not approach, or passes the stopping point
/// of `self` at more than the distance
std::optional<HalfSpace> evasion_plane(const Braking& self, const Vector3& p_other_local_m,
                                       const Vector3& v_other_local_mps, double distance_m, double vertical_m,
                                       const MotionLimits& limits);

/// Speed limit with no neighbor in view: another vehicle with the same speed may approach just beyond the sensor's
/// range. Both can still stop after detection.
/// @param unknown_s  time from entering the range to braking: period and latency of the sensor, and reaction
double speed_into_unknown_mps(double range_m, double unknown_s, double distance_m, double braking_mps2);

}  // namespace swiftlet
