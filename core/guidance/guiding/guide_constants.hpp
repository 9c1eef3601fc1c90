// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet {

/// Constants of the guide.
struct GuideConstants {
  /// [s] period of guiding messages. Larger values save radio capacity and correct the guided vehicle's path later.
  static constexpr double kGuidingPeriod_s = 0.2;
  /// [m] clearance around the figure that a lost vehicle flies: its radius and the error of its last known position.
  /// Larger values request smaller figures, or none.
  static constexpr double kFigureClearance_m = 0.6;
  /// [m] radius below which no figure is requested. Smaller figures hardly make the heading observable.
  static constexpr double kFigureMin_m = 0.3;
  /// [-] greatest distance of a waypoint that is sent while both fly, in multiples of the viewpoint's range of sight.
  /// Larger values send waypoints that the guide will see only from its next viewpoint.
  static constexpr double kSightFactor = 1.5;
  /// [m] radius around a guided vehicle's estimate within which occupied cells may be the vehicle itself. Smaller
  /// values cause needless planning, larger ones ignore obstacles directly before the vehicle.
  static constexpr double kOwnCells_m = 0.3;
  /// [m] remaining length of the guided vehicle's path at which the next leg is planned ahead. Larger values plan from
  /// an older map.
  static constexpr double kPlanAhead_m = 1.5;
  /// [s] delay from a failure to the next planning. Larger values wait longer for obstacles to move away.
  static constexpr double kRetryAfter_s = 2.0;
  /// [s] time without an estimate of the guided vehicle after which the guide requests a motion that makes this vehicle
  /// observable. Larger values interrupt fewer flights and find a lost vehicle later.
  static constexpr double kSearchAfter_s = 3.0;
};

}  // namespace swiftlet
