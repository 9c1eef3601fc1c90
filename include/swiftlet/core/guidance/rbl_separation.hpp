// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "swiftlet/core/control/motion_limits.hpp"
#include "swiftlet/core/guidance/neighbor_memory.hpp"
#include "swiftlet/core/guidance/rbl_cell.hpp"

namespace swiftlet {

/// What keeps vehicles apart where their cells alone do not. Not in the document.
struct RblSeparationConfig {
  bool enabled = true;
  double margin_m = 0.1;
  double sigmas = 2.0;
  double vertical_m = 1.5;
  double reaction_s = 0.2;
  double pledge_share = 0.45;
  double acceleration_mps2 = 2.5;
  double jerk_mps3 = 15.0;

  /// Those of the vehicle, where they are not above what it follows closely; the vertical ones in the same ratio.
  MotionLimits within(MotionLimits limits) const;
  void visit(ConfigVisitor& v);
};

/// A vehicle on the way that it flies if it brakes from now on.
struct Braking {
  Vector3 p_local_m = Vector3::Zero();
  Vector3 stop_local_m = Vector3::Zero();  ///< where it comes to rest
};

/// @param reaction_s  before the braking begins
Braking braking_of(const Vector3& p_local_m, const Vector3& v_local_mps, double reaction_s, const MotionLimits& limits);

/// The nearest points of two braking ways, and the plane halfway between them.
///
/// Each of two vehicles that keep their way on their own side of such planes can still stop there. So the distance
/// stays above `distance_m` as far as the ways are right. Heights count `distance_m / vertical_m` times, because
/// the rotors move the air above and below a vehicle.
/// @param unsure_m  by how much the other may be nearer; it takes room to advance, but never pushes back
/// @return relative to the place of `self`
HalfSpace braking_cut(const Braking& self, const Braking& other, double distance_m, double vertical_m, double unsure_m);

/// What a vehicle may use, until it knows more, of the room that was between it and another one when it saw it last.
///
/// When both use less than half, they stay apart whatever they do with it, and however seldom they see each other.
/// Nothing need be known of their speeds.
/// @param unsure_m  by how much the other may have been nearer
/// @return relative to `p_local_m`, where the vehicle is now
HalfSpace pledged_cut(const Vector3& own_seen_local_m, const Vector3& other_seen_local_m, const Vector3& p_local_m,
                      double distance_m, double vertical_m, double unsure_m, double share);

/// What lies beside the way of somebody who flies straight on. Whoever backs off before it is caught up with.
///
/// It is the side that the vehicle is on, or the right one as the other flies. The vehicle moves level, or up or down
/// where that is sooner done. Once it has begun, it goes on to the same side: each sample tells another one of somebody
/// who comes straight on.
/// @param begun_local  normal of the plane of the last time; nullptr: it begins
/// @return relative to the place of `self`; nothing when the other does not come, or passes `self` at its stop by more
///         than the distance
std::optional<HalfSpace> dodging_cut(const Braking& self, const Vector3& p_other_local_m,
                                     const Vector3& v_other_local_mps, double distance_m, double vertical_m,
                                     const MotionLimits& limits, const Vector3* begun_local = nullptr);

/// How fast a vehicle may fly that knows nobody ahead. One that flies towards it as fast may be just beyond the range
/// of its sensor. Both can still stop when they have seen each other.
/// @param unknown_s  from coming into range until the vehicle brakes: period and latency of the sensor, and reaction
double speed_into_unknown_mps(double range_m, double unknown_s, double distance_m, double braking_mps2);

}  // namespace swiftlet
