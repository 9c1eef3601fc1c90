// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "swiftlet/core/base/airframe.hpp"

/// The vehicles that Swiftlet comes with, for tests of core libraries, which read no files. Masses, arms, heights,
/// thrust constants and speeds of ctu-mrs/mrs_multirotor_simulator, torque ratio and motor lag of the MRS Gazebo
/// models; Kopterworx as in larics/ardupilot_gazebo. Drag: 0.30 pi L^2 |v|^2 as in mrs_multirotor_simulator.
namespace swiftlet::testing {

struct NamedAirframe {
  std::string name;
  Airframe airframe;
};

inline Airframe quad_x(double mass_kg, double arm_m, double height_m, double kf_N_per_rpm2, double rpm_min,
                       double rpm_max) {
  constexpr double kRpmPerRadps = 30.0 / std::numbers::pi;
  Airframe a;
  a.mass_kg = mass_kg;
  a.arm_length_m = arm_m;
  a.body_height_m = height_m;
  const double j = mass_kg * (3.0 * arm_m * arm_m + height_m * height_m) / 12.0;
  a.inertia_diagonal_kgm2 = {j, j, mass_kg * arm_m * arm_m / 2.0};
  a.thrust_constant_N_per_radps2 = kf_N_per_rpm2 * kRpmPerRadps * kRpmPerRadps;
  a.rotor_speed_min_radps = rpm_min / kRpmPerRadps;
  a.rotor_speed_max_radps = rpm_max / kRpmPerRadps;
  a.body_drag_area_m2.setConstant(2.0 * 0.30 * std::numbers::pi * arm_m * arm_m / 1.225);
  const double d = arm_m * std::sqrt(0.5);
  a.rotors = {{{d, -d, 0.5 * height_m}, Rotor::Spin::kCcw},
              {{-d, d, 0.5 * height_m}, Rotor::Spin::kCcw},
              {{d, d, 0.5 * height_m}, Rotor::Spin::kCw},
              {{-d, -d, 0.5 * height_m}, Rotor::Spin::kCw}};
  return a;
}

inline Airframe kopterworx() {
  Airframe a = quad_x(9.0, 0.52, 0.23, 1.0, 600.0, 6000.0);
  a.inertia_diagonal_kgm2 = {0.303755, 0.27722, 0.469164};
  a.thrust_constant_N_per_radps2 = 2.4407e-4;
  a.torque_to_thrust_m = 0.04415;
  a.rotor_inertia_kgm2 = 1.5e-3;
  a.motor_time_constant_up_s = a.motor_time_constant_down_s = 0.0125;
  a.rotor_speed_min_radps = 66.7;
  a.rotor_speed_max_radps = 667.0;
  a.rotor_drag_N_per_radps_mps = 8.06e-5;
  return a;
}

inline std::vector<NamedAirframe> all_airframes() {
  return {{"t650", quad_x(3.5, 0.325, 0.15, 7.3385e-7, 875, 5832)},
          {"f330", quad_x(1.4, 0.165, 0.07, 9.4268e-8, 1459, 9722)},
          {"f450", quad_x(1.7, 0.225, 0.1, 1.2216e-7, 1360, 9068)},
          {"x500", quad_x(2.0, 0.25, 0.1, 2.7087e-7, 1170, 7800)},
          {"kopterworx", kopterworx()}};
}

inline Airframe x500() { return all_airframes()[3].airframe; }

/// n rotors on a circle with alternating directions; each as strong as an X500's.
inline Airframe ring_of_rotors(int n) {
  Airframe a = x500();
  a.mass_kg = 0.5 * n;
  a.rotors.clear();
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + 0.5) / n;
    a.rotors.push_back({{a.arm_length_m * std::cos(angle), a.arm_length_m * std::sin(angle), 0.0},
                        i % 2 == 0 ? Rotor::Spin::kCcw : Rotor::Spin::kCw});
  }
  return a;
}

}  // namespace swiftlet::testing
