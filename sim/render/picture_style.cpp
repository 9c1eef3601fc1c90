// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/picture_style.hpp"

#include <algorithm>
#include <cstddef>

namespace swiftlet::sim {

PictureStyle style_of(const CameraConfig& camera) {
  PictureStyle style;
  style.cloud = camera.cloud;
  style.point_px = static_cast<float>(camera.point_px);
  style.trails = camera.trails && camera.type != CameraConfig::Type::kOnboard;
  style.overlays = camera.overlays;
  style.vehicle_scale = camera.vehicle_scale;
  style.cut_above = camera.cut_above;
  style.cut_height_m = camera.cut_height_m;
  style.white = camera.on_paper();
  return style;
}

HeightScale height_scale_of(std::span<const PictureCloud> clouds) {
  std::vector<float> heights;
  for (const PictureCloud& cloud : clouds) {
    for (const Eigen::Vector3f& p : cloud.points_world_m) heights.push_back(p.z());
  }
  if (heights.empty()) return {};
  // Quantiles, so that outliers do not stretch the scale.
  const auto quantile = [&](double q) {
    const auto nth = heights.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(heights.size() - 1));
    std::nth_element(heights.begin(), nth, heights.end());
    return *nth;
  };
  const float low = quantile(0.01);
  return {low, std::max(low + 0.5F, quantile(0.99))};
}

std::vector<PictureCloud> shown_of(std::span<const PictureCloud> clouds, const View& view, const PictureStyle& style) {
  const float cut_m = cut_of(style);
  const Eigen::Matrix4f clip_world = view.clip_world().cast<float>();
  std::vector<PictureCloud> shown;
  for (const PictureCloud& cloud : clouds) {
    PictureCloud& kept = shown.emplace_back();
    kept.vehicle = cloud.vehicle;
    for (std::size_t i = 0; i < cloud.points_world_m.size(); ++i) {
      const Eigen::Vector3f& p = cloud.points_world_m[i];
      const Eigen::Vector4f clip = clip_world * p.homogeneous();
      if (p.z() > cut_m || clip.head<2>().cwiseAbs().maxCoeff() > clip.w() || clip.z() < 0.0F || clip.z() > clip.w())
        continue;
      kept.points_world_m.push_back(p);
      if (i < cloud.intensity.size()) kept.intensity.push_back(cloud.intensity[i]);
      if (i < cloud.surface_class.size()) kept.surface_class.push_back(cloud.surface_class[i]);
    }
  }
  return shown;
}

float cut_of(const PictureStyle& style) { return style.cut_above ? static_cast<float>(style.cut_height_m) : kNoCut_m; }

}  // namespace swiftlet::sim
