// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/pursuit_laws.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {

void PursuitGains::visit(ConfigVisitor& v) {
  v.field("pure_pursuit", pure_pursuit, "[1/s^2] G of pure pursuit: acceleration toward the target per distance",
          Range::positive());
  v.field("proportional_navigation", proportional_navigation, "[-] N of proportional navigation", Range::positive());
  v.field("frpn", frpn, "[-] G of FRPN: gain of the acceleration", Range::positive());
}

double time_to_go_s(const PursuitGains& gains, const RelativeMotion& relative) {
  const double speed_mps = std::max(relative.v_mps.norm(), 1e-9);
  return std::clamp(relative.p_m.norm() / speed_mps, gains.time_to_go_min_s,
                    std::max(gains.time_to_go_min_s, gains.time_to_go_max_s));
}

Vector3 pure_pursuit_mps2(const PursuitGains& gains, const RelativeMotion& relative) {
  return gains.pure_pursuit * relative.p_m;
}

Vector3 proportional_navigation_mps2(const PursuitGains& gains, const RelativeMotion& relative) {
  const double t_s = time_to_go_s(gains, relative);
  return gains.proportional_navigation / (t_s * t_s) * (relative.p_m + t_s * relative.v_mps);
}

Vector3 frpn_mps2(const PursuitGains& gains, const RelativeMotion& relative) {
  const double t_s = time_to_go_s(gains, relative);
  return gains.frpn * ((1.0 - gains.frpn_weight) / (t_s * t_s) * (relative.p_m + t_s * relative.v_mps) +
                       gains.frpn_weight * relative.p_m);
}

Vector3 within_acceleration(const Vector3& a_mps2, const MotionLimits& limits) {
  const double horizontal = a_mps2.head<2>().norm() / limits.horizontal_acceleration_mps2;
  const double vertical = std::abs(a_mps2.z()) / limits.vertical_acceleration_mps2;
  return a_mps2 / std::max({1.0, horizontal, vertical});
}

}  // namespace swiftlet
