// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "sim/render/cameras.hpp"

namespace swiftlet::sim {

/// A vertex in clip coordinates.
struct ClipVertex {
  Eigen::Vector4f clip;
  Eigen::Vector4f color;  ///< sRGB and opacity
};

/// Appends a polyline of constant width in pixels as triangles with mitred joints (core profiles of OpenGL draw no wide
/// lines). Parts behind the camera are clipped. One color per point.
void append_polyline(const View& view, std::span<const Eigen::Vector3f> points_world_m,
                     std::span<const Eigen::Vector4f> colors, float width_px, std::vector<ClipVertex>& out);

}  // namespace swiftlet::sim
