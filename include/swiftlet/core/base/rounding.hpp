// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet {

/// [m, cells or -] Tolerance of coordinates and of the elements of rotations: far above their rounding errors, far
/// below what a sensor resolves. Larger values blur borders; smaller ones let rounding decide.
inline constexpr double kRounding = 1e-6;

}  // namespace swiftlet
