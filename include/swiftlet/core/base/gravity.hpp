// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet {

/// Gravitational acceleration of the simulated world, which the onboard software assumes.
inline constexpr double kGravity_mps2 = 9.81;

/// The unit g of accelerometers: 1 g = 9.80665 m/s^2 (ISO 80000-3). For conversion of units only.
inline constexpr double kStandardGravity_mps2 = 9.80665;

}  // namespace swiftlet
