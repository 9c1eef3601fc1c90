// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/gravity.hpp"

namespace swiftlet::sim {

/// Simulated physical effects. Each can be switched off alone.
struct PhysicsConfig {
  /// [kg/m^3] Density of air at sea level. Larger values increase the drag of bodies and weaken the wakes of rotors.
  static constexpr double kAirDensity_kgpm3 = 1.225;

  double step_s = 0.001;
  /// [m/s^2] gravity; larger magnitudes need more thrust to hover
  Eigen::Vector3d gravity_world_mps2 = {0.0, 0.0, -kGravity_mps2};
  bool motor_lag = true;
  bool gyroscopic_torque = true;
  bool rotor_drag = true;
  bool body_drag = true;
  bool ground_effect = true;
  bool downwash = true;
  bool contacts = true;
  double contact_friction = 0.6;  ///< Coulomb friction coefficient between a vehicle and any surface
  double contact_restitution = 0.1;
  /// Normal speed above which a contact is a crash; slower contacts are landings or brushes
  double crash_speed_mps = 0.5;
  bool propeller_contact_is_crash = true;  ///< any contact of a turning propeller is a crash, at any speed
  bool stop_motors_on_crash = true;

  void visit(ConfigVisitor& v);
};

/// Mean wind and Dryden turbulence (MIL-F-8785C, low altitude).
struct WindConfig {
  Eigen::Vector3d mean_mps = Eigen::Vector3d::Zero();
  bool gusts = false;
  double wind_at_6m_mps = 7.7;  ///< W20 of MIL-F-8785C: 7.7 light, 15.4 moderate, 23.2 severe

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
