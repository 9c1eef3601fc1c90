// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

namespace swiftlet {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

}  // namespace swiftlet
