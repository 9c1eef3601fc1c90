// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "swiftlet/core/base/airframe.hpp"
#include "swiftlet/sim/physics/physics_world.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// Air conditions at one vehicle, constant during a physics step.
struct AirAtVehicle {
  Vector3 wind_world_mps = Vector3::Zero();
  Vector3 downwash_world_mps = Vector3::Zero();         ///< added to the wind
  std::array<double, kMaxRotors> ground_effect_gain{};  ///< additional thrust as a fraction
};

/// Free flight of one multirotor: motors, rotors, air and gravity on a rigid body, without contacts.
///
/// The motors are integrated exactly: with a constant command, a first-order lag has a closed form. The body is
/// integrated by classical Runge-Kutta 4, with the rotor speeds at the beginning, middle and end of the step. This is
/// of fourth order and takes about a quarter of a microsecond; the semi-implicit Euler step of the physics engine is of
/// first order. At 1 kHz the integration error of an agile flight stays below a micrometer per second.
class MultirotorModel {
 public:
  MultirotorModel(const Airframe& airframe, const PhysicsConfig& config);

  /// One step of config.step_s. Does not change state.t. A negative command stops the rotor.
  void step(VehicleState& state, const std::array<double, kMaxRotors>& rotor_command, const AirAtVehicle& air) const;
  /// Advances only the motors, for a vehicle at rest on the ground.
  void step_motors(VehicleState& state, const std::array<double, kMaxRotors>& rotor_command) const;

  struct Acceleration {
    Vector3 linear_world_mps2;
    Vector3 angular_body_radps2;
  };
  /// Acceleration in free flight at this instant, with constant rotor speeds.
  Acceleration acceleration(const VehicleState& state, const AirAtVehicle& air) const;

  double thrust_N(const VehicleState& state) const;  ///< in free air, without ground effect
  const Airframe& airframe() const { return airframe_; }

 private:
  struct RotorLoad;  // forces and torques of the rotors on the body at one instant
  struct Motors;     // rotor speeds at three instants of a step

  Motors run_motors(VehicleState& state, const std::array<double, kMaxRotors>& rotor_command) const;
  RotorLoad load(const std::array<double, kMaxRotors>& speed, double momentum_rate, const AirAtVehicle& air) const;
  Acceleration accelerate(const RotorLoad& load, const Matrix3& R_world_body, const Vector3& v_world,
                          const Vector3& omega_body, const AirAtVehicle& air) const;

  Airframe airframe_;
  PhysicsConfig config_;
  int num_rotors_ = 0;
  std::array<double, kMaxRotors> direction_{};
  std::array<double, 2> half_step_decay_up_down_{};  // exp(-step / 2 / time constant)
  Vector3 inertia_ = Vector3::Ones();
  Vector3 inertia_inverse_ = Vector3::Ones();
  bool rotor_drag_ = false;
};

}  // namespace swiftlet::sim
