// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

namespace swiftlet {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

/// Angle of a configuration in radians; rounds as the quotient, which a factor of kRadPerDeg does not for every angle.
constexpr double radians(double angle_deg) { return angle_deg * kPi / 180.0; }
constexpr double degrees(double angle_rad) { return angle_rad * 180.0 / kPi; }

}  // namespace swiftlet
