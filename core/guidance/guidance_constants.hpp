// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Constants with one role in several parts of guidance.
namespace swiftlet {

/// [s] Period at which guidance among neighbors updates planes, cells, velocities and the nearest obstacle. Smaller
/// values react sooner and cost more time.
inline constexpr double kUpdatePeriod_s = 0.1;
/// [s] Time from the vehicle to the goal of the reference governor at the commanded velocity. Smaller values lower the
/// speed that the governor reaches; larger ones delay the turn to a new velocity.
inline constexpr double kGoalAhead_s = 1.0;
/// [m] Distance from the end, or the start, of a path within which the vehicle is there. Values below the error of
/// tracking never arrive; larger values begin or end a flight with an error.
inline constexpr double kArrived_m = 0.3;
/// [m/s] Speed below which a simulated reference counts as at rest. Smaller values simulate longer.
inline constexpr double kAtRest_mps = 0.02;
/// [m] Horizontal displacement below which the vehicle keeps its heading. Smaller values turn the vehicle about near a
/// goal, and for noise.
inline constexpr double kShortestToFace_m = 0.3;
/// [m] Tolerated violation of a plane. Must exceed rounding errors; larger values reduce the kept distance, smaller
/// ones need more projections.
inline constexpr double kOnPlane_m = 1e-3;

/// [m] Lower bound of distances in divisions; below it, directions are arbitrary. Larger values weaken responses to
/// near objects.
inline constexpr double kNearest_m = 1e-3;
/// [m] Length below which the normal of a plane is arbitrary; guards a division by 0. Larger values give neighbors at
/// nearly the same position a common normal.
inline constexpr double kSamePlace_m = 1e-6;
/// [m, m/s, -] Lengths, speeds and relative differences below this are rounding errors. Larger values ignore slow
/// motion; values below the rounding of double precision guard nothing.
inline constexpr double kNegligible = 1e-9;

}  // namespace swiftlet
