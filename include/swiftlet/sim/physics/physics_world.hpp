// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/base/airframe.hpp"
#include "swiftlet/sim/physics/physics_config.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/world/neighborhood.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

struct PhysicsVehicle {
  std::string name;
  Airframe airframe;
  VehicleState start;
  bool motors_on = false;  ///< start with rotors at hover speed (in the air) instead of at rest (on the ground)
};

/// A contact that ends a vehicle's flight. A collision of two vehicles gives one event for each.
struct Crash {
  TimeNs t = 0;
  VehicleId vehicle = kNoVehicle;
  VehicleId other_vehicle = kNoVehicle;                   ///< kNoVehicle: the static world
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;  ///< class of the surface of the static world
  std::uint16_t instance = 0;
  Vector3 p_world_m = Vector3::Zero();
  double speed_mps = 0.0;  ///< normal speed at the contact
};

/// Rigid bodies of all vehicles in one Bullet world with the static scene. Hides Bullet. A step of a vehicle takes
/// about a microsecond. Vehicles that cannot touch anything are distributed over the crew on duty. The result has the
/// same bits for any number of threads.
class PhysicsWorld {
 public:
  /// `seed` drives gusts. The static scene may be null (empty space).
  PhysicsWorld(const PhysicsConfig& config, const WindConfig& wind, std::vector<PhysicsVehicle> vehicles,
               std::shared_ptr<const StaticScene> scene, std::uint64_t seed);
  ~PhysicsWorld();

  /// Advances by whole physics steps to `t_end` with constant rotor commands; appends the state after each step to
  /// `history`. A command is 0..1 from least to greatest rotor speed, clamped; a negative one (or NaN) stops the rotor.
  void advance(TimeNs t_end, std::span<const std::array<double, kMaxRotors>> rotor_commands, StateHistory& history);

  const VehicleState& state(VehicleId vehicle) const;
  std::span<const VehicleState> states() const;
  /// Crashes of the last advance(), sorted by time.
  std::span<const Crash> crashes() const;
  /// True if the vehicle touches anything after the last advance().
  bool in_contact(VehicleId vehicle) const;
  /// Exact distances after the last advance(); a surface beyond `max_distance_m` is reported at that distance.
  /// Several threads may call this for different vehicles.
  Clearance clearance(VehicleId vehicle, double max_distance_m) const;
  /// Wind at the vehicle after the last step, world frame.
  Vector3 wind_world_mps(VehicleId vehicle) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace swiftlet::sim
