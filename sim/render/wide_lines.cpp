// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/wide_lines.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet::sim {
namespace {

// [half line widths] Longest miter at a corner. Larger values draw longer spikes at sharp corners.
constexpr float kMiterLimit = 2.0F;
// [px] Points nearer than this to the previous one are skipped, because the direction between them is undefined. Larger
// values simplify the line.
constexpr float kMinSegment_px = 0.25F;
// [-] Length of the sum of both segments' unit normals below which a corner counts as a reversal and gets two square
// ends instead of a miter. Larger values draw fewer miters.
constexpr float kReversal = 0.2F;
// [-] Smallest cosine between miter and segment normal in the length of a miter; avoids a division by zero.
constexpr float kMinMiterCosine = 0.1F;
// [-] Depth at which lines are clipped, relative to the near plane. Slightly above 1, so that clipped points stay
// visible despite rounding.
constexpr float kClipDepth = 1.001F;

/// Point of a polyline.
struct Corner {
  Eigen::Vector4f clip;   // in clip space
  Eigen::Vector2f pixel;  // relative to the middle of the picture
  Eigen::Vector4f color;
};

/// Appends the triangles of a ribbon along a part of a polyline that lies in front of the camera.
void append_ribbon(const View& view, const std::vector<Corner>& part, float width_px, std::vector<ClipVertex>& out) {
  std::vector<Corner> corners;
  for (const Corner& corner : part) {
    if (corners.empty() || (corner.pixel - corners.back().pixel).norm() > kMinSegment_px) corners.push_back(corner);
  }
  if (corners.size() < 2) return;
  const auto direction = [&](std::size_t i) -> Eigen::Vector2f {
    return (corners[i + 1].pixel - corners[i].pixel).normalized();
  };
  const auto normal_of = [](const Eigen::Vector2f& d) -> Eigen::Vector2f { return {-d.y(), d.x()}; };

  const auto displaced = [&](const Corner& corner, const Eigen::Vector2f& offset_px) {
    ClipVertex vertex{corner.clip, corner.color};
    vertex.clip.x() += offset_px.x() * 2.0F / static_cast<float>(view.width_px) * corner.clip.w();
    vertex.clip.y() += offset_px.y() * 2.0F / static_cast<float>(view.height_px) * corner.clip.w();
    return vertex;
  };

  std::vector<std::pair<ClipVertex, ClipVertex>> edges;  // left and right edge of the ribbon at each corner
  const float half = 0.5F * width_px;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2f normal_before = normal_of(direction(i > 0 ? i - 1 : 0));
    const Eigen::Vector2f normal_after = normal_of(direction(i + 1 < corners.size() ? i : i - 1));
    Eigen::Vector2f miter = normal_before + normal_after;
    if (miter.norm() < kReversal) {
      edges.emplace_back(displaced(corners[i], half * normal_before), displaced(corners[i], -half * normal_before));
      edges.emplace_back(displaced(corners[i], half * normal_after), displaced(corners[i], -half * normal_after));
      continue;
    }
    miter.normalize();
    const float length = half * std::min(kMiterLimit, 1.0F / std::max(kMinMiterCosine, miter.dot(normal_after)));
    edges.emplace_back(displaced(corners[i], length * miter), displaced(corners[i], -length * miter));
  }
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const auto& [a, b] = edges[i];
    const auto& [c, d] = edges[i + 1];
    out.insert(out.end(), {a, b, c, c, b, d});
  }
}

}  // namespace

void append_polyline(const View& view, std::span<const Eigen::Vector3f> points_world_m,
                     std::span<const Eigen::Vector4f> colors, float width_px, std::vector<ClipVertex>& out) {
  if (points_world_m.size() < 2) return;
  const Eigen::Matrix4f T_camera_world = view.T_camera_world.cast<float>();
  const Eigen::Matrix4f clip_camera = view.clip_camera.cast<float>();
  const float clip_z = -kClipDepth * static_cast<float>(view.near_m);
  const auto color_of = [&](std::size_t i) { return colors.size() == 1 ? colors[0] : colors[i]; };
  const auto corner_at = [&](const Eigen::Vector4f& camera, const Eigen::Vector4f& color) {
    const Eigen::Vector4f clip = clip_camera * camera;
    const Eigen::Vector2f pixel(0.5F * clip.x() / clip.w() * static_cast<float>(view.width_px),
                                0.5F * clip.y() / clip.w() * static_cast<float>(view.height_px));
    return Corner{clip, pixel, color};
  };

  std::vector<Corner> part;  // since the polyline last came in front of the camera
  Eigen::Vector4f previous;
  for (std::size_t i = 0; i < points_world_m.size(); ++i) {
    const Eigen::Vector4f camera = T_camera_world * points_world_m[i].homogeneous();
    const bool in_front = camera.z() <= clip_z;
    if (i > 0 && in_front != (previous.z() <= clip_z)) {  // the segment crosses the near plane
      const float s = (clip_z - previous.z()) / (camera.z() - previous.z());
      part.push_back(
          corner_at(previous + s * (camera - previous), color_of(i - 1) + s * (color_of(i) - color_of(i - 1))));
      if (!in_front) {
        append_ribbon(view, part, width_px, out);
        part.clear();
      }
    }
    if (in_front) part.push_back(corner_at(camera, color_of(i)));
    previous = camera;
  }
  append_ribbon(view, part, width_px, out);
}

}  // namespace swiftlet::sim
