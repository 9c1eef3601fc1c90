// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet {

/// Limits of the reference. Horizontal limits apply to the norm of the vector in the x-y plane.
struct MotionLimits {
  double horizontal_speed_mps = 4.0;
  double horizontal_acceleration_mps2 = 2.0;
  double horizontal_jerk_mps3 = 40.0;
  double vertical_speed_mps = 2.0;
  double vertical_acceleration_mps2 = 1.0;
  double vertical_jerk_mps3 = 40.0;
  double heading_rate_radps = 1.0;
  double heading_acceleration_radps2 = 1.0;
};

/// A named set of limits; a value other than 0 replaces that of the set.
///
/// "slow", "medium", "fast": the constraint sets of the MRS UAV system; "medium" equals Kamler 2025, Table 2.1.
/// "agile": sufficient for the trajectories of Vrba 2025, Table IV (8.2 m/s, 4.5 m/s^2), in any direction.
struct MotionLimitsConfig {
  enum class Set { kSlow, kMedium, kFast, kAgile };
  Set set = Set::kMedium;
  double horizontal_speed_mps = 0.0;
  double horizontal_acceleration_mps2 = 0.0;
  double horizontal_jerk_mps3 = 0.0;
  double vertical_speed_mps = 0.0;
  double vertical_acceleration_mps2 = 0.0;
  double vertical_jerk_mps3 = 0.0;
  double heading_rate_degps = 0.0;
  double heading_acceleration_degps2 = 0.0;

  void visit(ConfigVisitor& v);
  MotionLimits resolve() const;
};

}  // namespace swiftlet
