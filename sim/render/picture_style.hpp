// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/render/cameras.hpp"
#include "sim/render/picture_scene.hpp"
#include "swiftlet/sim/render/render_config.hpp"

namespace swiftlet::sim {

/// Range of heights for a cloud's colors and the legend.
struct HeightScale {
  float low_m = 0.0F;
  float high_m = 1.0F;
};

/// Selection and style of the drawn parts of a PictureScene.
struct PictureStyle {
  CloudColors cloud = CloudColors::kNone;  ///< as in CameraConfig
  std::optional<HeightScale> heights;      ///< range of a cloud's height colors; none: of all its points
  float point_px = 0.0F;                   ///< diameter of a cloud's points; 0: decreases with distance
  bool trails = true;
  std::vector<std::string> overlays;  ///< names of drawn overlays; "*": all
  double vehicle_scale = 1.0;
  VehicleId hidden_vehicle = kNoVehicle;  ///< carrier of the camera
  std::vector<VehicleId> watched;         ///< leaves between the camera and these vehicles are omitted
  bool cut_above = false;
  double cut_height_m = 3.0;
  bool white = false;       ///< without sky and haze
  bool quick = false;       ///< one sample per pixel and smoothing of edges afterwards, for videos: half the time
  float line_scale = 1.0F;  ///< widening of trails and lines
  // For tests: neither changes the picture near the camera.
  bool cull = true;
  bool reduce = true;  ///< draw fewer leaves and branches at large distances
};
PictureStyle style_of(const CameraConfig& camera);

HeightScale height_scale_of(std::span<const PictureCloud> clouds);
/// Points of clouds inside the view and below the cut, ignoring occlusion.
std::vector<PictureCloud> shown_of(std::span<const PictureCloud> clouds, const View& view, const PictureStyle& style);

inline constexpr float kNoCut_m = 1e9F;  ///< height of a cut that hides nothing
/// Height of the cut, world frame.
float cut_of(const PictureStyle& style);

}  // namespace swiftlet::sim
