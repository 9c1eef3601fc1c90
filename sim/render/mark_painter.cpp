// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/mark_painter.hpp"

#include <algorithm>
#include <cmath>

#include "embedded/sim_render.hpp"

namespace swiftlet::sim {
namespace {

struct SolidVertex {
  Eigen::Vector3f position;
  Eigen::Vector3f normal;
};
struct SolidInstance {
  Eigen::Vector4f center_size_m;
  Eigen::Vector4f color;
};

/// Cube with edge 1, as separate triangles.
std::vector<SolidVertex> unit_cube() {
  std::vector<SolidVertex> vertices;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-0.5F, 0.5F}) {
      Eigen::Vector3f normal = Eigen::Vector3f::Zero();
      normal[axis] = 2.0F * side;
      const auto corner = [&](float u, float v) {
        Eigen::Vector3f p;
        p[axis] = side;
        p[(axis + 1) % 3] = u;
        p[(axis + 2) % 3] = v;
        return SolidVertex{p, normal};
      };
      const SolidVertex a = corner(-0.5F, -0.5F), b = corner(0.5F, -0.5F), c = corner(0.5F, 0.5F),
                        d = corner(-0.5F, 0.5F);
      // Counter-clockwise seen from outside.
      if (side > 0.0F)
        vertices.insert(vertices.end(), {a, b, c, a, c, d});
      else
        vertices.insert(vertices.end(), {a, c, b, a, d, c});
    }
  }
  return vertices;
}

/// Sphere with radius 1, as separate triangles.
std::vector<SolidVertex> unit_sphere() {
  constexpr int kSlices = 16;
  constexpr int kStacks = 10;
  const auto at = [](int slice, int stack) {
    const double azimuth = 2.0 * M_PI * slice / kSlices;
    const double polar = M_PI * stack / kStacks;
    const Eigen::Vector3f p =
        Eigen::Vector3d(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar))
            .cast<float>();
    return SolidVertex{p, p};
  };
  std::vector<SolidVertex> vertices;
  for (int stack = 0; stack < kStacks; ++stack) {
    for (int slice = 0; slice < kSlices; ++slice) {
      const SolidVertex a = at(slice, stack), b = at(slice, stack + 1), c = at(slice + 1, stack + 1),
                        d = at(slice + 1, stack);
      vertices.insert(vertices.end(), {a, b, c, a, c, d});
    }
  }
  return vertices;
}

template <class T>
void stream(const GlFunctions& gl, GLuint buffer, std::span<const T> data) {
  gl.BindBuffer(GL_ARRAY_BUFFER, buffer);
  gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(data.size_bytes()), data.data(), GL_STREAM_DRAW);
}

}  // namespace

MarkPainter::MarkPainter(const GlFunctions& gl)
    : gl_(gl),
      point_program_(gl, "point", embedded::point_vert, embedded::point_frag),
      solid_program_(gl, "solid", embedded::solid_vert, embedded::solid_frag),
      clip_program_(gl, "clip", embedded::clip_vert, embedded::clip_frag) {
  points_ = make_vertex_buffer(gl_);
  float_attribute(gl_, 0, 3, sizeof(PointVertex), offsetof(PointVertex, p_world_m));
  float_attribute(gl_, 1, 4, sizeof(PointVertex), offsetof(PointVertex, color));
  clip_ = make_vertex_buffer(gl_);
  float_attribute(gl_, 0, 4, sizeof(ClipVertex), offsetof(ClipVertex, clip));
  float_attribute(gl_, 1, 4, sizeof(ClipVertex), offsetof(ClipVertex, color));
  // Triangles are drawn as solids of size 1 at the origin without normals.
  triangles_ = make_vertex_buffer(gl_);
  float_attribute(gl_, 0, 3, sizeof(PointVertex), offsetof(PointVertex, p_world_m));
  float_attribute(gl_, 3, 4, sizeof(PointVertex), offsetof(PointVertex, color));

  gl_.GenBuffers(1, &solid_instances_);
  const auto upload = [&](const std::vector<SolidVertex>& vertices) {
    const VertexBuffer made = make_vertex_buffer(gl_);
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(SolidVertex)), vertices.data(),
                   GL_STATIC_DRAW);
    float_attribute(gl_, 0, 3, sizeof(SolidVertex), offsetof(SolidVertex, position));
    float_attribute(gl_, 1, 3, sizeof(SolidVertex), offsetof(SolidVertex, normal));
    gl_.BindBuffer(GL_ARRAY_BUFFER, solid_instances_);
    float_attribute(gl_, 2, 4, sizeof(SolidInstance), offsetof(SolidInstance, center_size_m), 1);
    float_attribute(gl_, 3, 4, sizeof(SolidInstance), offsetof(SolidInstance, color), 1);
    return UnitSolid{made.array, static_cast<GLsizei>(vertices.size())};
  };
  cube_ = upload(unit_cube());
  sphere_ = upload(unit_sphere());
}

void MarkPainter::draw_points(const View& view, std::span<const PointVertex> points, const PointSize& size,
                              float cut_m) {
  if (points.empty()) return;
  point_program_.use();
  point_program_.set("u_clip_world", Eigen::Matrix4f(view.clip_world().cast<float>()));
  point_program_.set("u_pixels_at_1m", static_cast<float>(view.pixels_per_m(1.0)));
  point_program_.set("u_size_m", size.diameter_m);
  point_program_.set("u_min_px", size.least_px);
  point_program_.set("u_max_px", std::max(14.0F, size.least_px));
  point_program_.set("u_cut_m", cut_m);
  point_program_.set("u_viewport_px", Eigen::Vector2i(view.width_px, view.height_px).cast<float>().eval());
  gl_.Enable(GL_PROGRAM_POINT_SIZE);
  gl_.BindVertexArray(points_.array);
  stream(gl_, points_.buffer, points);
  gl_.DrawArrays(GL_POINTS, 0, static_cast<GLsizei>(points.size()));
}

void MarkPainter::use_solid_program(const View& view, const Eigen::Vector3f& sun_world, float cut_m) {
  solid_program_.use();
  solid_program_.set("u_clip_world", Eigen::Matrix4f(view.clip_world().cast<float>()));
  solid_program_.set("u_eye_m", Eigen::Vector3f(view.eye_world_m.cast<float>()));
  solid_program_.set("u_sun", sun_world);
  solid_program_.set("u_cut_m", cut_m);
}

void MarkPainter::draw_solids(const View& view, Solid solid, std::span<const Eigen::Vector4f> center_size_m,
                              std::span<const Eigen::Vector4f> colors, const Eigen::Vector3f& sun_world, float cut_m) {
  if (center_size_m.empty()) return;
  std::vector<SolidInstance> instances(center_size_m.size());
  for (std::size_t i = 0; i < instances.size(); ++i) instances[i] = {center_size_m[i], colors[i]};
  use_solid_program(view, sun_world, cut_m);
  const UnitSolid& unit = solid == Solid::kCube ? cube_ : sphere_;
  gl_.BindVertexArray(unit.array);
  stream(gl_, solid_instances_, std::span<const SolidInstance>(instances));
  gl_.Enable(GL_CULL_FACE);  // back faces are hidden, or would be blended twice
  gl_.DrawArraysInstanced(GL_TRIANGLES, 0, unit.num_vertices, static_cast<GLsizei>(instances.size()));
  gl_.Disable(GL_CULL_FACE);
}

void MarkPainter::draw_triangles(const View& view, std::span<const Eigen::Vector3f> corners_world_m,
                                 std::span<const Eigen::Vector4f> colors, const Eigen::Vector3f& sun_world,
                                 float cut_m) {
  if (corners_world_m.size() < 3) return;
  std::vector<PointVertex> vertices(corners_world_m.size() / 3 * 3);
  for (std::size_t i = 0; i < vertices.size(); ++i) vertices[i] = {corners_world_m[i], colors[i]};
  use_solid_program(view, sun_world, cut_m);
  gl_.BindVertexArray(triangles_.array);
  gl_.VertexAttrib4f(1, 0.0F, 0.0F, 0.0F, 0.0F);
  gl_.VertexAttrib4f(2, 0.0F, 0.0F, 0.0F, 1.0F);
  stream(gl_, triangles_.buffer, std::span<const PointVertex>(vertices));
  gl_.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices.size()));
}

void MarkPainter::draw_clip(std::span<const ClipVertex> triangles, float opacity) {
  if (triangles.empty()) return;
  clip_program_.use();
  clip_program_.set("u_opacity", opacity);
  gl_.BindVertexArray(clip_.array);
  stream(gl_, clip_.buffer, triangles);
  gl_.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(triangles.size()));
}

}  // namespace swiftlet::sim
