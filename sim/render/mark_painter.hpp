// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "sim/render/cameras.hpp"
#include "sim/render/gl_objects_internal.hpp"
#include "sim/render/wide_lines.hpp"

namespace swiftlet::sim {

struct PointVertex {
  Eigen::Vector3f p_world_m;
  Eigen::Vector4f color;  ///< sRGB and opacity
};

/// Point size that decreases with distance, but not below `least_px`.
struct PointSize {
  float diameter_m = 0.0F;
  float least_px = 2.2F;
};

/// Draws marks over the world: points, wide lines, cubes, spheres, triangles.
/// The caller sets blending and depth test.
class MarkPainter {
 public:
  enum class Solid { kCube, kSphere };

  explicit MarkPainter(const GlFunctions& gl);

  void draw_points(const View& view, std::span<const PointVertex> points, const PointSize& size, float cut_m);
  /// `center_size_m` contains center and size of each solid as (x, y, z, size).
  void draw_solids(const View& view, Solid solid, std::span<const Eigen::Vector4f> center_size_m,
                   std::span<const Eigen::Vector4f> colors, const Eigen::Vector3f& sun_world, float cut_m);
  void draw_triangles(const View& view, std::span<const Eigen::Vector3f> corners_world_m,
                      std::span<const Eigen::Vector4f> colors, const Eigen::Vector3f& sun_world, float cut_m);
  void draw_clip(std::span<const ClipVertex> triangles, float opacity);

 private:
  void use_solid_program(const View& view, const Eigen::Vector3f& sun_world, float cut_m);

  const GlFunctions& gl_;
  Program point_program_;
  Program solid_program_;
  Program clip_program_;
  VertexBuffer points_;
  VertexBuffer clip_;
  VertexBuffer triangles_;
  struct UnitSolid {
    GLuint array = 0;
    GLsizei num_vertices = 0;
  };
  UnitSolid cube_;
  UnitSolid sphere_;
  GLuint solid_instances_ = 0;
};

}  // namespace swiftlet::sim
