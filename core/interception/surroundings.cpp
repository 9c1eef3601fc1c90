// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/surroundings.hpp"

#include <algorithm>
#include <limits>

#include "core/interception/pursuit_laws.hpp"

namespace swiftlet {
namespace {

struct ClearanceTuning {
  /// [m] Distance beyond the clearance up to which obstacles constrain a plan. Larger values let fast vehicles avoid
  /// them earlier, but constrain more plans.
  double wall_reach_m = 3.0;
  double max_room_m = 1.0;  ///< [m] largest free distance that intrusion_m() reports; limits the search in the map
  /// [-] Height above a moving obstacle, in its radii, from which the vehicle passes over it instead of beside it.
  double over_height = 0.5;
  /// [m] Horizontal distance beyond the radius up to which a vehicle above a moving obstacle stays above its top.
  double over_reach_m = 0.5;
  double brake_step_s = 0.02;  ///< [s] time step of simulated braking
  /// [s] Period of the clearance checks during simulated braking. Larger values are faster, but may miss a violation.
  double brake_check_s = 0.1;
  double max_brake_s = 6.0;  ///< [s] longest simulated braking; then the vehicle counts as able to stop
  /// [1/s] Gain from velocity to braking acceleration, before the limit. Larger values brake at the limit to lower
  /// speeds.
  double brake_gain_per_s = 6.0;
  /// While braking, the vehicle evades moving obstacles that will come nearer than their radius plus this margin [m]
  /// within this time [s]. Larger values evade earlier and more obstacles, but lengthen the braking distance.
  double evade_s = 1.5, evade_room_m = 0.3;
  /// [-] Acceleration of an evasion over the limit of horizontal acceleration. It is added to that of braking before
  /// the sum is limited. Larger values evade more and brake less.
  double evade_gain = 2.0;
  /// [m] Miss distance below which the direction of an evasion is undefined; the vehicle climbs instead.
  double min_direction_m = 0.1;
  double rest_mps = 0.05;         ///< [m/s] speed below which a vehicle counts as stopped
  double min_distance_m = 1e-6;   ///< [m] nearer obstacles are coincident and give no plane
  double min_speed_sq = 1e-6;     ///< [m^2/s^2] lower bound of a squared relative speed; avoids a division by zero
  double cell_half_edges = 0.87;  ///< [-] half the space diagonal of a cell over its edge, rounded up
};
constexpr ClearanceTuning kClearance;

}  // namespace

double Surroundings::intrusion_m(const Vector3& p_local_m, double ahead_s) const {
  double largest_m = std::max(-kClearance.max_room_m, fence.excess_m(p_local_m));
  if (map != nullptr)
    largest_m = std::max(largest_m, clearance_m - map->distance_m(p_local_m, clearance_m + kClearance.max_room_m));
  for (const MovingObstacle& obstacle : moving_obstacles)
    largest_m = std::max(largest_m, obstacle.radius_m - (p_local_m - obstacle.at(ahead_s)).norm());
  return largest_m;
}

void Surroundings::walls(const Vector3& p_local_m, double ahead_s, ChaseAim& aim) const {
  aim.num_walls = 0;
  const auto add = [&](const Wall& wall) {
    if (aim.num_walls < ChaseAim::kMaxWalls) aim.walls[static_cast<std::size_t>(aim.num_walls++)] = wall;
  };
  // Adds the tangent plane of a sphere to keep out of, on the side of the position.
  const auto add_sphere = [&](const Vector3& center_m, double radius_m) {
    const Vector3 away = p_local_m - center_m;
    const double distance_m = away.norm();
    if (distance_m > radius_m + kClearance.wall_reach_m || distance_m < kClearance.min_distance_m) return;
    const Vector3 normal = -away / distance_m;
    add({normal, normal.dot(center_m) - radius_m});
  };
  if (map != nullptr) {
    map->occupied_within(p_local_m, clearance_m + kClearance.wall_reach_m, kEver, cells_local_m);
    const auto nearest =
        std::min_element(cells_local_m.begin(), cells_local_m.end(), [&](const Vector3& a, const Vector3& b) {
          return (a - p_local_m).squaredNorm() < (b - p_local_m).squaredNorm();
        });
    if (nearest != cells_local_m.end()) add_sphere(*nearest, clearance_m + kClearance.cell_half_edges * map->edge_m());
  }
  for (const MovingObstacle& obstacle : moving_obstacles) {
    const Vector3 center_m = obstacle.at(ahead_s), above = p_local_m - center_m;
    if (!obstacle.flown_over || above.z() < kClearance.over_height * obstacle.radius_m)
      add_sphere(center_m, obstacle.radius_m + obstacle.plan_room_m);
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
    // Relative position at the closest approach, at constant velocities.
    const double nearest_s =
        std::clamp(-p_m.dot(v_mps) / std::max(v_mps.squaredNorm(), kClearance.min_speed_sq), 0.0, kClearance.evade_s);
    const Vector3 miss_m = p_m + nearest_s * v_mps;
    if (miss_m.norm() > obstacle.radius_m + kClearance.evade_room_m) continue;
    const Vector3 away =
        miss_m.norm() > kClearance.min_direction_m ? Vector3(miss_m.normalized()) : Vector3(Vector3::UnitZ());
    a_mps2 += kClearance.evade_gain * limits.horizontal_acceleration_mps2 * away;
  }
  return within_acceleration(a_mps2, limits);
}

bool can_stop(ReferenceGovernor governor, const Surroundings& surroundings, double ahead_s, double allowed_m) {
  if (surroundings.intrusion_m(governor.state().position_m, ahead_s) > allowed_m) return false;
  double checked_s = 0.0;
  const int steps = static_cast<int>(kClearance.max_brake_s / kClearance.brake_step_s);
  for (int i = 1; i <= steps; ++i) {
    const double t_s = i * kClearance.brake_step_s;
    governor.accelerate(braking_mps2(governor.state(), surroundings, ahead_s + t_s, governor.limits()),
                        governor.state().yaw_rad, kClearance.brake_step_s);
    const bool rests = governor.state().velocity_mps.norm() < kClearance.rest_mps;
    if (!rests && t_s - checked_s < kClearance.brake_check_s) continue;
    checked_s = t_s;
    if (surroundings.intrusion_m(governor.state().position_m, ahead_s + t_s) > allowed_m) return false;
    if (rests) return true;
  }
  return true;
}

}  // namespace swiftlet
