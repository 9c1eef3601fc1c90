// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "core/interception/geofence.hpp"
#include "core/interception/path_ahead.hpp"
#include "swiftlet/core/control/reference_governor.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// A flying object from which a distance is kept. Local frame.
struct MovingObstacle {
  Vector3 p_local_m = Vector3::Zero(), v_local_mps = Vector3::Zero();
  double radius_m = 0.0;
  bool flown_over = false;          ///< a vehicle above it stays above
  double plan_room_m = 0.0;         ///< added to the radius in plans, but not for braking
  const PathAhead* path = nullptr;  ///< reported path; null: it flies straight on
  double path_age_s = 0.0;

  Vector3 at(double ahead_s) const {
    if (path == nullptr) return p_local_m + ahead_s * v_local_mps;
    return p_local_m + path->at(path_age_s + ahead_s) - path->at(path_age_s);
  }
  Vector3 velocity_mps(double ahead_s) const {
    return path == nullptr ? v_local_mps : path->velocity_mps(path_age_s + ahead_s);
  }
};

/// Present obstacles of an interceptor: fence, map and moving obstacles.
struct Surroundings {
  Geofence fence;
  const OccupancyView* map = nullptr;  ///< null: no map
  double clearance_m = 1.0;            ///< from the vehicle's center to occupied cells
  std::vector<MovingObstacle> moving_obstacles;

  /// Largest violation of a distance to keep, at a position some time ahead; negative: the room left, at most 1 m.
  double intrusion_m(const Vector3& p_local_m, double ahead_s) const;
  /// Sets the half-spaces to keep to near a position, at most ChaseAim::kMaxWalls: those of the map, of
  /// moving obstacles, then of the fence.
  void walls(const Vector3& p_local_m, double ahead_s, ChaseAim& aim) const;

  mutable std::vector<Vector3> cells_local_m = {};  ///< reused memory of a query
};

/// Acceleration that brakes as hard as the limits allow and evades moving obstacles that come too near.
Vector3 braking_mps2(const Reference& state, const Surroundings& surroundings, double ahead_s,
                     const MotionLimits& limits);

/// True if braking from here keeps clear of everything.
/// @param allowed_m  present intrusion, which may stay
bool can_stop(ReferenceGovernor governor, const Surroundings& surroundings, double ahead_s, double allowed_m);

}  // namespace swiftlet
