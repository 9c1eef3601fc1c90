// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/separation_config.hpp"

namespace swiftlet {

MotionLimits SeparationConfig::within(MotionLimits limits) const {
  const auto cap = [](double& level, double& vertical, double most) {
    if (level <= most) return;
    vertical *= most / level;
    level = most;
  };
  cap(limits.horizontal_acceleration_mps2, limits.vertical_acceleration_mps2, acceleration_mps2);
  cap(limits.horizontal_jerk_mps3, limits.vertical_jerk_mps3, jerk_mps3);
  return limits;
}

void SeparationConfig::visit(ConfigVisitor& v) {
  v.field("enabled", enabled,
          "[-] whether braking planes, pledges and evasion keep vehicles apart; false: the guidance alone does");
  v.field("margin_m", margin_m, "[m] margin for the control error, added to the sum of the encumbrances",
          Range::non_negative());
  v.field("sigmas", sigmas, "[-] standard deviations of a neighbor's position that are subtracted from its distance",
          Range::non_negative());
  v.field("vertical_m", vertical_m, "[m] vertical distance to keep between two vehicles, because of the downwash",
          Range::positive());
  v.field("acceleration_mps2", acceleration_mps2,
          "[m/s^2] upper limit below the motion limits, so that the controller follows within margin_m",
          Range::positive());
  v.field("jerk_mps3", jerk_mps3, "[m/s^3] upper limit below the motion limits; the vehicle must tilt as fast",
          Range::positive());
}

void KeepApartConfig::visit(ConfigVisitor& v) {
  SeparationConfig::visit(v);
  v.field("encumbrance_m", encumbrance_m,
          "[m] radius of the zone around each vehicle; centers keep twice this distance", Range::positive());
  v.field("z_min_m", z_min_m, "[m] lowest height of an evasion");
  v.field("z_max_m", z_max_m, "[m] highest height of an evasion");
  v.object("neighbors", neighbors, "source of the neighbors to keep apart from");
  v.check(z_max_m > z_min_m, "z_max_m", "more than z_min_m");
}

}  // namespace swiftlet
