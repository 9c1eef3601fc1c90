// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "sim/physics/air_effects.hpp"
#include "sim/physics/multirotor_model.hpp"
#include "sim/physics/wind.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"

namespace swiftlet::sim {

/// [m] Search distance beyond the needed one. Larger values make searches rarer, and each of them slower.
inline constexpr double kSurfaceSlack_m = 2.0;

/// Distance to the nearest surface from an earlier position: at p it is at least distance - |p - from|.
struct SurfaceBound {
  Vector3 from_world_m = Vector3::Zero();
  double distance_m = 0.0;
  bool exact = false;  // true: exact distance; false: lower bound

  double at_least_m(const Vector3& p_world) const { return distance_m - (p_world - from_world_m).norm(); }
};

/// One vehicle of a PhysicsWorld, with bounds on the distance of its surroundings.
struct WorldVehicle {
  WorldVehicle(std::string vehicle_name, MultirotorModel vehicle_model)
      : name(std::move(vehicle_name)), model(std::move(vehicle_model)) {}

  std::string name;
  MultirotorModel model;
  AirAtVehicle air;
  std::optional<Gusts> gusts;
  double circumscribed_m = 0.0;
  double contact_reach_m = 0.0;  // radius of the collision shape plus margin
  double acceleration_bound_mps2 = 0.0;
  SurfaceBound surface;

  // Result of the current prediction:
  bool near_world = false;  // may touch a triangle before its end
  bool near = false;        // may touch a triangle or another vehicle before its end
  double travel_m = 0.0;    // upper bound of the displacement until its end

  bool touching = false;
  bool asleep = false;
  double still_s = 0.0;
  MultirotorModel::Acceleration free_acceleration{};  // at the time of freezing
};

/// Updates the distance to the nearest surface, searched within the radius.
void measure_surface(WorldVehicle& vehicle, const Vector3& p_world, double radius_m, const StaticScene& scene);
/// True if the vehicle may touch a surface before the prediction ends.
bool may_meet_surface(WorldVehicle& vehicle, const Vector3& p_world, const PhysicsConfig& config,
                      const StaticScene& scene);
/// Distance from the vehicle's circumscribed sphere to the nearest surface [m], at most max_distance_m.
double surface_clearance_m(WorldVehicle& vehicle, const Vector3& p_world, double max_distance_m,
                           const StaticScene& scene);
/// Ground effect of each rotor from its height above the surface, by a vertical ray.
void apply_ground_effect(WorldVehicle& vehicle, const VehicleState& state, const PhysicsConfig& config,
                         const StaticScene& scene);

}  // namespace swiftlet::sim
