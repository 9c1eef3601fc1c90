// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/control/motion_limits.hpp"

#include <stdexcept>
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// Limits of the sets slow, medium, fast and agile: horizontal speed [m/s], acceleration [m/s^2] and jerk [m/s^3], the
// same vertically, heading rate [rad/s] and heading acceleration [rad/s^2].
constexpr MotionLimits kSets[] = {{1.0, 1.0, 20.0, 1.0, 1.0, 20.0, 0.5, 1.0},
                                  {4.0, 2.0, 40.0, 2.0, 1.0, 40.0, 1.0, 1.0},
                                  {8.0, 4.0, 60.0, 4.0, 2.0, 60.0, 2.0, 2.0},
                                  {10.0, 6.0, 80.0, 8.5, 5.0, 80.0, 2.0, 4.0}};

void replace_if_given(double& value, double given) {
  if (given != 0.0) value = given;
}

}  // namespace

void MotionLimitsConfig::visit(ConfigVisitor& v) {
  v.choice("set", set, {"slow", "medium", "fast", "agile"},
           "[-] set of limits; a value other than 0 of a key below replaces a limit of the set");
  const Range range = Range::non_negative();
  v.field("horizontal_speed_mps", horizontal_speed_mps, "[m/s] largest horizontal speed; 0: from the set", range);
  v.field("horizontal_acceleration_mps2", horizontal_acceleration_mps2,
          "[m/s^2] largest horizontal acceleration; 0: from the set", range);
  v.field("horizontal_jerk_mps3", horizontal_jerk_mps3, "[m/s^3] largest horizontal jerk; 0: from the set", range);
  v.field("vertical_speed_mps", vertical_speed_mps, "[m/s] largest vertical speed; 0: from the set", range);
  v.field("vertical_acceleration_mps2", vertical_acceleration_mps2,
          "[m/s^2] largest vertical acceleration; 0: from the set", range);
  v.field("vertical_jerk_mps3", vertical_jerk_mps3, "[m/s^3] largest vertical jerk; 0: from the set", range);
  v.field("heading_rate_degps", heading_rate_degps, "[deg/s] largest rate of the heading; 0: from the set", range);
  v.field("heading_acceleration_degps2", heading_acceleration_degps2,
          "[deg/s^2] largest angular acceleration of the heading; 0: from the set", range);
}

MotionLimits MotionLimitsConfig::resolve() const {
  MotionLimits limits = kSets[static_cast<std::size_t>(set)];
  replace_if_given(limits.horizontal_speed_mps, horizontal_speed_mps);
  replace_if_given(limits.horizontal_acceleration_mps2, horizontal_acceleration_mps2);
  replace_if_given(limits.horizontal_jerk_mps3, horizontal_jerk_mps3);
  replace_if_given(limits.vertical_speed_mps, vertical_speed_mps);
  replace_if_given(limits.vertical_acceleration_mps2, vertical_acceleration_mps2);
  replace_if_given(limits.vertical_jerk_mps3, vertical_jerk_mps3);
  replace_if_given(limits.heading_rate_radps, heading_rate_degps * kRadPerDeg);
  replace_if_given(limits.heading_acceleration_radps2, heading_acceleration_degps2 * kRadPerDeg);
  return limits;
}

}  // namespace swiftlet
