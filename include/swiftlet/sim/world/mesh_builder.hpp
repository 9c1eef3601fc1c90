// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "swiftlet/sim/world/scene.hpp"

/// Solids that are appended to a mesh. Counter-clockwise seen from outside. A polygon that approximates a circle has
/// the circle's area, and an icosphere the sphere's volume, so volumes equal their closed forms at any resolution. Any
/// frame, the same for all arguments.
namespace swiftlet::sim {

void add_triangle(Mesh& mesh, const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c);
/// Corners counter-clockwise.
void add_quad(Mesh& mesh, const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
              const Eigen::Vector3f& d);
void add_box(Mesh& mesh, const Eigen::Vector3f& min_m, const Eigen::Vector3f& max_m);
/// A box of `size_m` centered at the origin of `T`.
void add_box(Mesh& mesh, const Eigen::Affine3f& T, const Eigen::Vector3f& size_m);

enum class Caps { kNone, kStart, kEnd, kBoth };

/// Round tube along a polyline, a radius at each point (none may be 0).
void add_tube(Mesh& mesh, std::span<const Eigen::Vector3f> points_m, std::span<const float> radii_m, int sides,
              Caps caps);
/// A tube of one segment: a cylinder when the radii are equal.
void add_frustum(Mesh& mesh, const Eigen::Vector3f& from_m, float radius_from_m, const Eigen::Vector3f& to_m,
                 float radius_to_m, int sides, Caps caps = Caps::kBoth);
/// 20 * 4^subdivisions triangles.
void add_icosphere(Mesh& mesh, const Eigen::Vector3f& center_m, float radius_m, int subdivisions);
/// Grid of (columns x rows) heights, row-major, x along a row; open surface facing up.
void add_heightfield(Mesh& mesh, const Eigen::Vector2f& origin_m, const Eigen::Vector2f& cell_m, int columns, int rows,
                     std::span<const float> heights_m);
void append(Mesh& mesh, const Mesh& other, const Eigen::Affine3f& T);

/// Volume by the divergence theorem; positive for a closed mesh with outward normals [m^3].
double signed_volume_m3(const Mesh& mesh);
double area_m2(const Mesh& mesh);
Eigen::AlignedBox3f bounds_m(const Mesh& mesh);

}  // namespace swiftlet::sim
