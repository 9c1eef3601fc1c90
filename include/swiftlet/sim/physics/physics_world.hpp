// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/airframe.hpp"
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

/// A contact that broke a vehicle. Two vehicles that meet give one event each.
struct Crash {
  TimeNs t = 0;
  VehicleId vehicle = kNoVehicle;
  VehicleId other_vehicle = kNoVehicle;                   ///< kNoVehicle: the static world
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;  ///< what of the static world
  std::uint16_t instance = 0;
  Vector3 p_world_m = Vector3::Zero();
  double speed_mps = 0.0;  ///< normal speed at the contact
};

/// Rigid bodies of all vehicles in one Bullet world with the static scene. Hides Bullet. A step of a vehicle costs
/// about a microsecond. Many vehicles are shared out to the crew on duty as long as they cannot touch anything. That
/// gives the same bits for any number of threads.
class PhysicsWorld {
 public:
  /// `seed` drives gusts. The static scene may be null (empty space).
  PhysicsWorld(const PhysicsConfig& config, const WindConfig& wind, std::vector<PhysicsVehicle> vehicles,
               std::shared_ptr<const StaticScene> scene, std::uint64_t seed);
  ~PhysicsWorld();

  /// Advances by whole physics steps to `t_end`, rotor commands held; pushes the state after each step to `history`.
  /// A command is 0..1 from least to greatest rotor speed, clamped; a negative one (or NaN) lets the rotor stop.
  void advance(TimeNs t_end, std::span<const std::array<double, kMaxRotors>> rotor_commands, StateHistory& history);

  const VehicleState& state(VehicleId vehicle) const;
  std::span<const VehicleState> states() const;
  /// Crashes of the last advance(), in order of time.
  std::span<const Crash> crashes() const;
  /// Vehicles touching something after the last advance().
  bool in_contact(VehicleId vehicle) const;
  /// Distances after the last advance(), measured exactly; a surface beyond `max_distance_m` is reported as that far.
  /// Different vehicles may be asked by different threads.
  Clearance clearance(VehicleId vehicle, double max_distance_m) const;
  /// Wind at the vehicle after the last step, world frame.
  Vector3 wind_world_mps(VehicleId vehicle) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace swiftlet::sim
