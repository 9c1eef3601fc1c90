// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/base/airframe.hpp"
#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/base/elementary.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {

void Rotor::visit(ConfigVisitor& v) {
  v.field("position_m", position_m, "[m] position of the hub in the body frame", Range::between(-10.0, 10.0));
  v.choice("spin", spin, {"ccw", "cw"}, "[-] sense of rotation seen from above");
}

void Airframe::visit(ConfigVisitor& v) {
  v.field("mass_kg", mass_kg, "[kg] take-off mass with payload; the rotors must be able to carry 1.1 times its weight",
          Range::between(0.001, 1000.0));
  v.field("inertia_diagonal_kgm2", inertia_diagonal_kgm2,
          "[kg m^2] principal moments of inertia about the body axes; none exceeds the sum of the other two",
          Range::between(1e-8, 1000.0));
  v.field("arm_length_m", arm_length_m, "[m] distance from center to rotor hub", Range::between(0.001, 10.0));
  v.field("body_height_m", body_height_m, "[m] height of the body", Range::between(0.001, 10.0));
  v.field("body_radius_m", body_radius_m, "[m] radius of the central plates", Range::between(0.001, 10.0));
  v.field("leg_height_m", leg_height_m,
          "[m] height of the center of mass above the ground when the vehicle stands on the legs",
          Range::between(0.001, 10.0));
  v.field("propeller_radius_m", propeller_radius_m, "[m]", Range::between(0.001, 10.0));
  v.field("propeller_blades", propeller_blades, "[-] blades of a propeller", Range::between(2, 6));
  v.field("thrust_constant_N_per_radps2", thrust_constant_N_per_radps2,
          "[N/(rad/s)^2] thrust of a rotor per squared rotor speed", Range::between(1e-12, 1.0));
  v.field("torque_to_thrust_m", torque_to_thrust_m, "[m] drag torque of a rotor per thrust", Range{0.0, 10.0, true});
  v.field("rotor_inertia_kgm2", rotor_inertia_kgm2,
          "[kg m^2] moment of inertia of motor bell and propeller about the axis", Range::between(0.0, 1.0));
  v.field("motor_time_constant_up_s", motor_time_constant_up_s, "[s] first-order lag when speeding up",
          Range::between(1e-4, 10.0));
  v.field("motor_time_constant_down_s", motor_time_constant_down_s, "[s] first-order lag when slowing down",
          Range::between(1e-4, 10.0));
  v.field("rotor_speed_min_radps", rotor_speed_min_radps, "[rad/s] rotor speed at command 0", Range::between(0.0, 1e5));
  v.field("rotor_speed_max_radps", rotor_speed_max_radps, "[rad/s] rotor speed at command 1", Range{0.0, 1e5, true});
  v.field("rotor_drag_N_per_radps_mps", rotor_drag_N_per_radps_mps,
          "[N/((rad/s)(m/s))] in-plane drag of a rotor per rotor speed and velocity in the rotor plane",
          Range::between(0.0, 1.0));
  v.field("body_drag_area_m2", body_drag_area_m2, "[m^2] drag coefficient times area along the body axes",
          Range::between(0.0, 100.0));
  v.field("reflectivity", reflectivity, "[-] Lambertian reflectivity of the frame at the LiDAR's wavelength",
          Range::probability());
  v.list("rotors", rotors, "in the order of the commands");
  // Each principal moment is at most the sum of the others; the margin allows for rounded data sheets.
  v.check(2.0 * inertia_diagonal_kgm2.maxCoeff() <= 1.0001 * inertia_diagonal_kgm2.sum(), "inertia_diagonal_kgm2",
          "moments of inertia of which none exceeds the sum of the other two");
  v.check(rotor_speed_max_radps > rotor_speed_min_radps, "rotor_speed_max_radps", "more than rotor_speed_min_radps");
  v.check(num_rotors() <= kMaxRotors, "rotors", "at most 8 rotors");
}

double Airframe::circumscribed_radius_m() const {
  // The ends of the skids extend to twice the body's radius (sim/world draws them so).
  double radius_m = std::max(elementary::hypot(body_radius_m, 0.5 * body_height_m),
                             elementary::hypot(2.0 * body_radius_m, leg_height_m));
  for (const Rotor& rotor : rotors) {
    const double reach_m = elementary::hypot(rotor.position_m.x(), rotor.position_m.y()) + propeller_radius_m;
    radius_m = std::max(radius_m, elementary::hypot(reach_m, rotor.position_m.z()));
  }
  return radius_m;
}

double Airframe::hover_rotor_speed_radps(double gravity_mps2) const {
  return std::sqrt(mass_kg * gravity_mps2 / (num_rotors() * thrust_constant_N_per_radps2));
}

}  // namespace swiftlet
