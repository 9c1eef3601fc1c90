// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/wide_lines.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet::sim {
namespace {

// [half line widths] Longest miter at a corner. Larger values draw longer spikes at sharp corners.
constexpr float kMiterLimit = 2.0F;

struct Corner {
  Eigen::Vector4f clip;
  Eigen::Vector2f pixel;
  Eigen::Vector4f color;
};

/// Converts consecutive points in front of the camera into a ribbon.
void append_ribbon(const View& view, const std::vector<Corner>& run, float width_px, std::vector<ClipVertex>& out) {
  // Coincident points in pixels have no direction.
  std::vector<Corner> corners;
  for (const Corner& corner : run) {
    if (corners.empty() || (corner.pixel - corners.back().pixel).norm() > 0.25F) corners.push_back(corner);
  }
  if (corners.size() < 2) return;
  const auto direction = [&](std::size_t i) -> Eigen::Vector2f {
    return (corners[i + 1].pixel - corners[i].pixel).normalized();
  };
  const auto side_of = [](const Eigen::Vector2f& d) -> Eigen::Vector2f { return {-d.y(), d.x()}; };

  const auto emit = [&](const Corner& corner, const Eigen::Vector2f& offset_px) {
    ClipVertex vertex{corner.clip, corner.color};
    vertex.clip.x() += offset_px.x() * 2.0F / static_cast<float>(view.width_px) * corner.clip.w();
    vertex.clip.y() += offset_px.y() * 2.0F / static_cast<float>(view.height_px) * corner.clip.w();
    return vertex;
  };

  std::vector<std::pair<ClipVertex, ClipVertex>> rungs;
  const float half = 0.5F * width_px;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2f before = side_of(direction(i > 0 ? i - 1 : 0));
    const Eigen::Vector2f after = side_of(direction(i + 1 < corners.size() ? i : i - 1));
    Eigen::Vector2f miter = before + after;
    if (miter.norm() < 0.2F) {  // sharp reversal: two rungs
      rungs.emplace_back(emit(corners[i], half * before), emit(corners[i], -half * before));
      rungs.emplace_back(emit(corners[i], half * after), emit(corners[i], -half * after));
      continue;
    }
    miter.normalize();
    const float length = half * std::min(kMiterLimit, 1.0F / std::max(0.1F, miter.dot(after)));
    rungs.emplace_back(emit(corners[i], length * miter), emit(corners[i], -length * miter));
  }
  for (std::size_t i = 0; i + 1 < rungs.size(); ++i) {
    const auto& [a, b] = rungs[i];
    const auto& [c, d] = rungs[i + 1];
    out.insert(out.end(), {a, b, c, c, b, d});
  }
}

}  // namespace

void append_polyline(const View& view, std::span<const Eigen::Vector3f> points_world_m,
                     std::span<const Eigen::Vector4f> colors, float width_px, std::vector<ClipVertex>& out) {
  if (points_world_m.size() < 2) return;
  const Eigen::Matrix4f T_camera_world = view.T_camera_world.cast<float>();
  const Eigen::Matrix4f clip_camera = view.clip_camera.cast<float>();
  const float nearest_z = -1.001F * static_cast<float>(view.near_m);
  const auto color_of = [&](std::size_t i) { return colors.size() == 1 ? colors[0] : colors[i]; };
  const auto corner_at = [&](const Eigen::Vector4f& camera, const Eigen::Vector4f& color) {
    const Eigen::Vector4f clip = clip_camera * camera;
    const Eigen::Vector2f pixel(0.5F * clip.x() / clip.w() * static_cast<float>(view.width_px),
                                0.5F * clip.y() / clip.w() * static_cast<float>(view.height_px));
    return Corner{clip, pixel, color};
  };

  std::vector<Corner> run;
  Eigen::Vector4f previous;
  for (std::size_t i = 0; i < points_world_m.size(); ++i) {
    const Eigen::Vector4f camera = T_camera_world * points_world_m[i].homogeneous();
    const bool in_front = camera.z() <= nearest_z;
    if (i > 0 && in_front != (previous.z() <= nearest_z)) {  // the segment crosses the near plane
      const float s = (nearest_z - previous.z()) / (camera.z() - previous.z());
      run.push_back(
          corner_at(previous + s * (camera - previous), color_of(i - 1) + s * (color_of(i) - color_of(i - 1))));
      if (!in_front) {
        append_ribbon(view, run, width_px, out);
        run.clear();
      }
    }
    if (in_front) run.push_back(corner_at(camera, color_of(i)));
    previous = camera;
  }
  append_ribbon(view, run, width_px, out);
}

}  // namespace swiftlet::sim
