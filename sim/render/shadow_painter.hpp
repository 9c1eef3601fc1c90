// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <span>

#include "sim/render/picture_scene.hpp"
#include "sim/render/picture_style.hpp"
#include "sim/render/vehicle_painter.hpp"
#include "sim/render/world_painter.hpp"

namespace swiftlet::sim {

/// Direction to the sun.
extern const Eigen::Vector3f kSun_world;
/// Direction to the sun of a style: high for a cut world, so that stumps have short shadows.
const Eigen::Vector3f& sun_of(const PictureStyle& style);

/// Sets the uniforms of a mesh program (mesh, depth or ghost), and uses it.
void set_mesh_uniforms(const Program& program, const Eigen::Matrix4f& clip_world, float cut_m);

/// Depth along the rays of the sun.
struct Shadow {
  Target target;
  Eigen::Matrix4f texture_world = Eigen::Matrix4f::Identity();
  float texel_m = 0.0F;
};

/// Draws the shadow maps of a picture.
class ShadowPainter {
 public:
  /// Both must outlive the painter.
  ShadowPainter(const GlFunctions& gl, const Program& depth_program) : gl_(gl), depth_program_(depth_program) {}

  /// Draws the shadow of the world once for each height of the cut: world and sun are static.
  void draw_world(const WorldPainter& world, const PictureStyle& style);
  /// @param radii_m  circumscribed radius of each vehicle
  void draw_vehicles(const VehiclePainter& vehicles, std::span<const float> radii_m, const PictureScene& picture,
                     const PictureStyle& style);
  /// Shadow of the world, drawn before.
  const Shadow& of_world(const PictureStyle& style) const { return world_shadows_.at(cut_of(style)); }
  const Shadow& of_vehicles() const { return vehicle_shadow_; }

 private:
  void begin(int texels, const Eigen::Matrix4f& clip_world, float cut_m);

  const GlFunctions& gl_;
  const Program& depth_program_;
  std::map<float, Shadow> world_shadows_;  // indexed by height of the cut
  Shadow vehicle_shadow_;
};

}  // namespace swiftlet::sim
