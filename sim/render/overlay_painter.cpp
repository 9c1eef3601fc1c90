// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/overlay_painter.hpp"

#include <algorithm>
#include <numeric>

#include "sim/render/shadow_painter.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

// [px] Width of a trail without its outline.
constexpr float kTrailWidth_px = 3.2F;

Eigen::Vector4f color_at(const Overlay& overlay, std::size_t i) {
  if (overlay.colors.empty()) return {1.0F, 0.75F, 0.1F, 1.0F};
  return overlay.colors[std::min(i, overlay.colors.size() - 1)];
}

void draw_solid_overlay(const GlFunctions& gl, MarkPainter& marks, const View& view, const Overlay& overlay,
                        float cut_m) {
  const bool cubes = overlay.kind == Overlay::Kind::kCubes;
  const std::size_t corners = overlay.kind == Overlay::Kind::kTriangles ? 3 : 1;
  const std::size_t n = overlay.positions.size() / corners;
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const bool opaque = is_opaque(overlay);
  if (!opaque) {  // sorted from far to near
    const Eigen::Vector3f back = view.T_camera_world.block<1, 3>(2, 0).transpose().cast<float>();
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return back.dot(overlay.positions[corners * a]) < back.dot(overlay.positions[corners * b]);
    });
  }
  gl.DepthMask(opaque ? GL_TRUE : GL_FALSE);
  std::vector<Eigen::Vector4f> colors;
  if (corners == 1) {
    std::vector<Eigen::Vector4f> center_size;
    for (const std::size_t i : order) {
      const Eigen::Vector3f& p = overlay.positions[i];
      center_size.emplace_back(p.x(), p.y(), p.z(), overlay.size_m);
      colors.push_back(color_at(overlay, i));
    }
    marks.draw_solids(view, cubes ? MarkPainter::Solid::kCube : MarkPainter::Solid::kSphere, center_size, colors,
                      kSun_world, cut_m);
  } else {
    std::vector<Eigen::Vector3f> positions;
    for (const std::size_t i : order) {
      for (std::size_t c = 0; c < 3; ++c) {
        positions.push_back(overlay.positions[3 * i + c]);
        colors.push_back(color_at(overlay, 3 * i + c));
      }
    }
    marks.draw_triangles(view, positions, colors, kSun_world, cut_m);
  }
  gl.DepthMask(GL_FALSE);
}

}  // namespace

bool is_opaque(const Overlay& overlay) {
  return std::all_of(overlay.colors.begin(), overlay.colors.end(), [](const auto& c) { return c.w() >= 0.995F; });
}

void draw_overlay(const GlFunctions& gl, MarkPainter& marks, const View& view, const Overlay& overlay,
                  const PictureStyle& style) {
  const float width_px = overlay.size_m * style.line_scale;
  std::vector<ClipVertex> lines;
  switch (overlay.kind) {
    case Overlay::Kind::kPoints: {
      std::vector<PointVertex> points;
      for (std::size_t i = 0; i < overlay.positions.size(); ++i)
        points.push_back({overlay.positions[i], color_at(overlay, i)});
      gl.DepthMask(is_opaque(overlay) ? GL_TRUE : GL_FALSE);
      marks.draw_points(view, points, {overlay.size_m}, cut_of(style));
      gl.DepthMask(GL_FALSE);
      return;
    }
    case Overlay::Kind::kLines:
      for (std::size_t i = 0; i + 1 < overlay.positions.size(); i += 2) {
        const Eigen::Vector4f colors[] = {color_at(overlay, i), color_at(overlay, i + 1)};
        append_polyline(view, std::span(overlay.positions).subspan(i, 2), colors, width_px, lines);
      }
      break;
    case Overlay::Kind::kPolyline: {
      std::vector<Eigen::Vector4f> colors;
      for (std::size_t i = 0; i < overlay.positions.size(); ++i) colors.push_back(color_at(overlay, i));
      append_polyline(view, overlay.positions, colors, width_px, lines);
      break;
    }
    case Overlay::Kind::kCubes:
    case Overlay::Kind::kSpheres:
    case Overlay::Kind::kTriangles:
      draw_solid_overlay(gl, marks, view, overlay, cut_of(style));
      return;
  }
  marks.draw_clip(lines, 1.0F);
}

void append_trails(const View& view, const PictureScene& picture, float line_scale, std::vector<ClipVertex>& outline,
                   std::vector<ClipVertex>& ribbon) {
  for (std::size_t v = 0; v < std::min(picture.trails_m.size(), picture.states.size()); ++v) {
    std::vector<Eigen::Vector3f> points = picture.trails_m[v];
    points.push_back(picture.states[v].p_world_m.cast<float>());
    if (points.size() < 2) continue;
    std::vector<Eigen::Vector4f> colors(points.size());
    std::vector<Eigen::Vector4f> dark(points.size());
    const Rgb color = vehicle_color(static_cast<VehicleId>(v));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const float age = 1.0F - static_cast<float>(i) / static_cast<float>(points.size() - 1);
      const float alpha = 1.0F - 0.7F * age;
      colors[i] = with_alpha(color, alpha);
      dark[i] = with_alpha(0.18F * color, 0.75F * alpha);
    }
    append_polyline(view, points, dark, line_scale * (kTrailWidth_px + 2.4F), outline);
    append_polyline(view, points, colors, line_scale * kTrailWidth_px, ribbon);
  }
}

}  // namespace swiftlet::sim
