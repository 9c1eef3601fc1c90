// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/world_vehicle.hpp"

#include <algorithm>

namespace swiftlet::sim {
namespace {

// [propeller radii] Height of the center below which a ray is traced from each rotor to the ground; above it one ray
// from the center serves all. Larger values cost time, smaller ones miss edges below single rotors.
constexpr double kPerRotorGroundRadii = 6.0;

double ground_effect_reach_m(const WorldVehicle& vehicle, const PhysicsConfig& config) {
  return config.ground_effect ? kGroundEffectReachRadii * vehicle.model.airframe().propeller_radius_m : 0.0;
}

}  // namespace

bool may_meet_surface(WorldVehicle& vehicle, const Vector3& p_world, const PhysicsConfig& config,
                      const StaticScene& scene) {
  const double reach_m = vehicle.contact_reach_m + vehicle.travel_m;
  if (vehicle.surface.at_least_m(p_world) > reach_m) return false;
  if (vehicle.asleep) return true;
  const double radius_m = reach_m + std::max(kSurfaceSlack_m, ground_effect_reach_m(vehicle, config));
  measure_surface(vehicle, p_world, radius_m, scene);
  return vehicle.surface.distance_m <= reach_m;
}

void measure_surface(WorldVehicle& vehicle, const Vector3& p_world, double radius_m, const StaticScene& scene) {
  const std::optional<NearestSurface> nearest = scene.nearest(p_world, radius_m);
  vehicle.surface = {p_world, nearest ? nearest->distance_m : radius_m, nearest.has_value()};
}

// The known distance at an earlier position bounds the search. Without a near surface, the search extends beyond the
// requested distance, so that its result holds longer.
double surface_clearance_m(WorldVehicle& vehicle, const Vector3& p_world, double max_distance_m,
                           const StaticScene& scene) {
  const double search_m = max_distance_m + vehicle.circumscribed_m;
  if (vehicle.surface.at_least_m(p_world) >= search_m) return max_distance_m;
  const double moved_m = (p_world - vehicle.surface.from_world_m).norm();
  const double known_m =
      vehicle.surface.exact ? (vehicle.surface.distance_m + moved_m) * (1.0 + 1e-6) + 1e-6 : search_m + kSurfaceSlack_m;
  measure_surface(vehicle, p_world, std::min(known_m, search_m + kSurfaceSlack_m), scene);
  if (!vehicle.surface.exact) return max_distance_m;
  return std::min(vehicle.surface.distance_m - vehicle.circumscribed_m, max_distance_m);
}

void apply_ground_effect(WorldVehicle& vehicle, const VehicleState& state, const PhysicsConfig& config,
                         const StaticScene& scene) {
  vehicle.air.ground_effect_gain.fill(0.0);
  const double reach_m = ground_effect_reach_m(vehicle, config);
  const Matrix3 R_world_body = state.q_world_body.toRotationMatrix();
  const double upright = R_world_body(2, 2);
  if (upright <= 0.0 || vehicle.surface.at_least_m(state.p_world_m) > reach_m) return;
  const Vector3 down = -Vector3::UnitZ();
  const double center_height_m = scene.trace(state.p_world_m, down, reach_m).range_m;
  const Airframe& airframe = vehicle.model.airframe();
  const bool high = center_height_m > kPerRotorGroundRadii * airframe.propeller_radius_m;
  if (center_height_m <= 0.0 && vehicle.surface.at_least_m(state.p_world_m) > airframe.arm_length_m) return;
  for (int i = 0; i < airframe.num_rotors(); ++i) {
    const Vector3 arm_world = R_world_body * airframe.rotors[i].position_m;
    double height_m = center_height_m + arm_world.z();
    if (!high) {
      height_m = scene.trace(state.p_world_m + arm_world, down, reach_m).range_m;
      if (height_m <= 0.0) continue;
    }
    vehicle.air.ground_effect_gain[i] =
        upright * ground_effect_gain(height_m, airframe.propeller_radius_m, kGroundEffectCoefficient);
  }
}

}  // namespace swiftlet::sim
