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

/// Colors of a cloud's heights, for the legend.
struct HeightScale {
  float low_m = 0.0F;
  float high_m = 1.0F;
};

/// What of a PictureScene is drawn, and how.
struct PictureStyle {
  CloudColors cloud = CloudColors::kNone;  ///< as CameraConfig
  std::optional<HeightScale> heights;      ///< of the colors of a cloud; none: of all of its points
  float point_px = 0.0F;                   ///< diameter of a cloud's points; 0: by their distance
  bool trails = true;
  std::vector<std::string> overlays;  ///< by name; "*": all
  double vehicle_scale = 1.0;
  VehicleId hidden_vehicle = kNoVehicle;  ///< the one that carries the camera
  std::vector<VehicleId> watched;         ///< leaves between the camera and these are left out
  bool cut_above = false;
  double cut_height_m = 3.0;
  bool white = false;       ///< neither sky nor haze
  bool quick = false;       ///< one sample a pixel and edges smoothed after, for videos: half the time
  float line_scale = 1.0F;  ///< trails and lines are wider by this
  // For tests: neither changes what is seen near the camera.
  bool cull = true;
  bool reduce = true;  ///< fewer leaves and branches far away
};
PictureStyle style_of(const CameraConfig& camera);

HeightScale height_scale_of(std::span<const PictureCloud> clouds);
/// The points of clouds that a picture shows: in the view and below the cut. Nothing that hides them is asked for.
std::vector<PictureCloud> shown_of(std::span<const PictureCloud> clouds, const View& view, const PictureStyle& style);

inline constexpr float kNoCut_m = 1e9F;  ///< height of a cut that hides nothing
/// Height of the cut, world frame.
float cut_of(const PictureStyle& style);

}  // namespace swiftlet::sim
