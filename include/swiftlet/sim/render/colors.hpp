// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {

using Rgb = Eigen::Vector3f;  ///< sRGB, 0..1

inline Eigen::Vector4f with_alpha(const Rgb& color, float alpha) { return {color.x(), color.y(), color.z(), alpha}; }

/// Perceptually uniform, dark violet to yellow; s in 0..1 (clamped). For intensities.
Rgb viridis_like(float s);
/// Rainbow of even lightness steps, dark blue to dark red; s in 0..1 (clamped). For distances.
Rgb turbo_like(float s);
/// The bright part of turbo_like, for points drawn over a scene: readable on soil and on leaves.
Rgb height_color(float s);
/// Distinct colors for the vehicles of a team, visible on green and on gray.
Rgb vehicle_color(VehicleId vehicle);
/// Color of a truth class (SurfaceClass) or of a vehicle.
Rgb class_color(std::uint16_t surface_class);

/// Color of a part of a vehicle; body and arms carry the vehicle's color.
Rgb part_color(const VehicleShape& shape, const Mesh& mesh, VehicleId vehicle);

/// Conversion from sRGB to linear light, per channel.
Rgb to_linear(const Rgb& srgb);
/// Relative luminance of WCAG 2: 0 black, 1 white.
float luminance(const Rgb& srgb);
/// The color itself, or darker, so that its contrast with a white halo is 4.5 or more (WCAG 2, level AA).
Rgb ink_of(const Rgb& srgb);
/// Euclidean distance in OKLab [Ottosson 2020]. About 0.02 is just noticeable; black and white differ by 1.
float color_difference(const Rgb& a_srgb, const Rgb& b_srgb);

}  // namespace swiftlet::sim
