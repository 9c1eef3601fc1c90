// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/gravity.hpp"

namespace swiftlet {

/// One rotor of a multirotor.
struct Rotor {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< hub, body frame (origin: center of mass)
  enum class Spin { kCcw, kCw };
  Spin spin = Spin::kCcw;  ///< seen from above: "ccw" or "cw"

  void visit(ConfigVisitor& v);
  /// +1 for a rotor whose angular momentum points up (ccw), -1 otherwise.
  double direction() const { return spin == Rotor::Spin::kCcw ? 1.0 : -1.0; }
};

/// Physical data of a multirotor, as in a data sheet. The simulator uses it as the truth, the controller as its model,
/// and the world for the vehicle's shape.
struct Airframe {
  double mass_kg = 2.0;
  Eigen::Vector3d inertia_diagonal_kgm2 = {0.0217, 0.0217, 0.04};
  double arm_length_m = 0.25;  ///< center to rotor hub
  double body_height_m = 0.1;
  double body_radius_m = 0.12;  ///< radius of the central plates
  double leg_height_m = 0.2;    ///< height of the center of mass above the ground when the vehicle stands on its legs
  double propeller_radius_m = 0.15;
  int propeller_blades = 2;
  double thrust_constant_N_per_radps2 = 2.47e-5;  ///< thrust of a rotor per squared rotor speed
  double torque_to_thrust_m = 0.016;              ///< drag torque of a rotor per thrust
  double rotor_inertia_kgm2 = 6e-5;
  double motor_time_constant_up_s = 0.0125;
  double motor_time_constant_down_s = 0.025;
  double rotor_speed_min_radps = 122.5;
  double rotor_speed_max_radps = 816.8;
  double rotor_drag_N_per_radps_mps =
      0.0;  ///< H-force of a rotor: -this * speed * velocity in the rotor plane [N per (rad/s)(m/s)]
  Eigen::Vector3d body_drag_area_m2 = {0.02, 0.02, 0.05};  ///< C_d * A along the body axes
  double reflectivity = 0.3;                               ///< reflectivity of frame and body at the LiDAR's wavelength
  std::vector<Rotor> rotors;                               ///< in the order of Action::rotor_command

  void visit(ConfigVisitor& v);

  int num_rotors() const { return static_cast<int>(rotors.size()); }
  /// Radius of the sphere around the center of mass that encloses the whole vehicle with its propellers [m].
  double circumscribed_radius_m() const;
  /// Rotor speed at hover: the thrusts of all rotors equal the weight [rad/s].
  double hover_rotor_speed_radps(double gravity_mps2 = kGravity_mps2) const;
  double max_thrust_N() const {
    return num_rotors() * thrust_constant_N_per_radps2 * rotor_speed_max_radps * rotor_speed_max_radps;
  }
};

}  // namespace swiftlet
