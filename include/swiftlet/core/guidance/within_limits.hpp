// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

#include "swiftlet/core/control/motion_limits.hpp"

namespace swiftlet {

/// Throws std::invalid_argument when a value of a guidance module exceeds a motion limit.
inline void expect_within(const std::string& guidance, const char* key, double value, double limit) {
  if (value <= limit) return;
  throw std::invalid_argument("guidance " + guidance + ": " + key + ": expected at most " + std::to_string(limit) +
                              " (control.limits), found " + std::to_string(value));
}

/// Checks speed and acceleration in arbitrary directions against the horizontal limits.
inline void expect_within(const std::string& guidance, const MotionLimits& limits, const char* speed_key,
                          double speed_mps, const char* acceleration_key, double acceleration_mps2) {
  expect_within(guidance, speed_key, speed_mps, limits.horizontal_speed_mps);
  expect_within(guidance, acceleration_key, acceleration_mps2, limits.horizontal_acceleration_mps2);
}

}  // namespace swiftlet
