// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/surroundings.hpp"

#include <algorithm>
#include <limits>

#include "core/interception/pursuit_laws.hpp"

namespace swiftlet {
namespace {

struct ClearanceTuning {
  double wall_reach_m = 3.0;  ///< [m] walls farther from a position are ignored there
  double max_room_m = 1.0;    ///< [m] largest room that is reported
  /// [-] Height in radii above a moving obstacle from which it is flown over.
  double over_height = 0.5;
  double over_reach_m = 0.5;  ///< [m] horizontal distance beyond the radius within which its top is a floor
  double brake_step_s = 0.02, brake_check_s = 0.1;  ///< [s] step of simulated braking, and period of its checks
  double max_brake_s = 6.0;                         ///< [s] longest simulated braking
  double brake_gain_per_s = 6.0;                    ///< [1/s] gain from velocity to braking acceleration
  /// [s, m] While braking, moving obstacles that come nearer than their radius and this room within this time are
  /// evaded.
  double evade_s = 1.5, evade_room_m = 0.3;
  double min_direction_m = 0.1;  ///< [m] nearer passages give no direction; the vehicle climbs
  double rest_mps = 0.05;        ///< [m/s] speed below which a vehicle has stopped
};
constexpr ClearanceTuning kClearance;

}  // namespace

double Surroundings::intrusion_m(const Vector3& p_local_m, double ahead_s) const {
  double worst_m = std::max(-kClearance.max_room_m, fence.excess_m(p_local_m));
  if (map != nullptr)
    worst_m = std::max(worst_m, clearance_m - map->distance_m(p_local_m, clearance_m + kClearance.max_room_m));
  for (const MovingObstacle& obstacle : moving_obstacles)
    worst_m = std::max(worst_m, obstacle.radius_m - (p_local_m - obstacle.at(ahead_s)).norm());
  return worst_m;
}

void Surroundings::walls(const Vector3& p_local_m, double ahead_s, ChaseAim& aim) const {
  aim.num_walls = 0;
  const auto add = [&](const Wall& wall) {
    if (aim.num_walls < ChaseAim::kMaxWalls) aim.walls[static_cast<std::size_t>(aim.num_walls++)] = wall;
  };
  const auto keep_from = [&](const Vector3& center_m, double radius_m) {
    const Vector3 away = p_local_m - center_m;
    const double distance_m = away.norm();
    if (distance_m > radius_m + kClearance.wall_reach_m || distance_m < 1e-6) return;
    const Vector3 normal = -away / distance_m;
    add({normal, normal.dot(center_m) - radius_m});
  };
  if (map != nullptr) {
    map->occupied_within(p_local_m, clearance_m + kClearance.wall_reach_m, kEver, cells_local_m);
    const auto nearest =
        std::min_element(cells_local_m.begin(), cells_local_m.end(), [&](const Vector3& a, const Vector3& b) {
          return (a - p_local_m).squaredNorm() < (b - p_local_m).squaredNorm();
        });
    if (nearest != cells_local_m.end())
      keep_from(*nearest, clearance_m + 0.87 * map->edge_m());  // half the diagonal of a cell
  }
  for (const MovingObstacle& obstacle : moving_obstacles) {
    const Vector3 center_m = obstacle.at(ahead_s), above = p_local_m - center_m;
    if (!obstacle.flown_over || above.z() < kClearance.over_height * obstacle.radius_m)
      keep_from(center_m, obstacle.radius_m + obstacle.plan_room_m);
    else if (above.head<2>().norm() < obstacle.radius_m + kClearance.over_reach_m)
      add({-Vector3::UnitZ(), -(center_m.z() + obstacle.radius_m)});
  }
  for (const Wall& side : fence.sides()) {
    if (side.excess_m(p_local_m) > -kClearance.wall_reach_m) add(side);
  }
}

Vector3 braking_mps2(const Reference& state, const Surroundings& surroundings, double ahead_s,
                     const MotionLimits& limits) {
  Vector3 a_mps2 = -kClearance.brake_gain_per_s * state.velocity_mps;
  for (const MovingObstacle& obstacle : surroundings.moving_obstacles) {
    const Vector3 p_m = state.position_m - obstacle.at(ahead_s),
                  v_mps = state.velocity_mps - obstacle.velocity_mps(ahead_s);
    // Closest approach, if both fly straight on.
    const double nearest_s = std::clamp(-p_m.dot(v_mps) / std::max(v_mps.squaredNorm(), 1e-6), 0.0, kClearance.evade_s);
    const Vector3 then_m = p_m + nearest_s * v_mps;
    if (then_m.norm() > obstacle.radius_m + kClearance.evade_room_m) continue;
    const Vector3 away =
        then_m.norm() > kClearance.min_direction_m ? Vector3(then_m.normalized()) : Vector3(Vector3::UnitZ());
    a_mps2 += 2.0 * limits.horizontal_acceleration_mps2 * away;
  }
  return within_acceleration(a_mps2, limits);
}

bool can_stop(ReferenceGovernor governor, const Surroundings& surroundings, double ahead_s, double allowed_m) {
  if (surroundings.intrusion_m(governor.state().position_m, ahead_s) > allowed_m) return false;
  double looked_s = 0.0;
  const int steps = static_cast<int>(kClearance.max_brake_s / kClearance.brake_step_s);
  for (int i = 1; i <= steps; ++i) {
    const double t_s = i * kClearance.brake_step_s;
    governor.accelerate(braking_mps2(governor.state(), surroundings, ahead_s + t_s, governor.limits()),
                        governor.state().yaw_rad, kClearance.brake_step_s);
    const bool rests = governor.state().velocity_mps.norm() < kClearance.rest_mps;
    if (!rests && t_s - looked_s < kClearance.brake_check_s) continue;
    looked_s = t_s;
    if (surroundings.intrusion_m(governor.state().position_m, ahead_s + t_s) > allowed_m) return false;
    if (rests) return true;
  }
  return true;
}

}  // namespace swiftlet
