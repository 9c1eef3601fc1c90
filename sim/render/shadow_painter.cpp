// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/shadow_painter.hpp"

#include <algorithm>

namespace swiftlet::sim {
namespace {

// [texels] Largest edge of the shadow map of the world. Larger values sharpen shadows in large worlds and take memory.
constexpr int kMaxShadowTexels = 4096;
// [m] Edge of a texel in worlds small enough for kMaxShadowTexels. Smaller values sharpen shadows and take memory.
constexpr float kShadowTexel_m = 0.045F;
// [texels] Edge of the shadow map of the vehicles. Larger values sharpen shadows and take memory.
constexpr int kVehicleShadowTexels = 1024;
// [-] Largest number of stored shadow maps of the world, one per height of the cut. Larger values take more memory, but
// maps are drawn again less often.
constexpr std::size_t kShadowsKept = 3;

const Eigen::Vector3f kHighSun = Eigen::Vector3f(-0.20F, 0.09F, 0.97F).normalized();

/// Parallel projection along the sun's rays around a box: x, y to [-1, 1], depth to [0, 1] from the sun.
Eigen::Matrix4f clip_of_sun(const Eigen::Vector3f& sun, const Eigen::AlignedBox3f& box, float& width_m) {
  const Eigen::Vector3f right = Eigen::Vector3f::UnitZ().cross(sun).normalized();
  const Eigen::Vector3f up = sun.cross(right);
  Eigen::Matrix4f clip = Eigen::Matrix4f::Identity();
  clip.block<1, 3>(0, 0) = right.transpose();
  clip.block<1, 3>(1, 0) = up.transpose();
  clip.block<1, 3>(2, 0) = -sun.transpose();
  Eigen::AlignedBox3f around;
  for (int corner = 0; corner < 8; ++corner) {
    around.extend((clip * box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(corner)).homogeneous()).head<3>());
  }
  const Eigen::Vector3f size = around.sizes().array() + 0.2F;
  width_m = size.head<2>().maxCoeff();
  const Eigen::Vector3f center = around.center();
  Eigen::Matrix4f fit = Eigen::Matrix4f::Identity();
  for (int axis = 0; axis < 2; ++axis) {
    fit(axis, axis) = 2.0F / size[axis];
    fit(axis, 3) = -2.0F * center[axis] / size[axis];
  }
  fit(2, 2) = 1.0F / size.z();
  fit(2, 3) = 0.5F - center.z() / size.z();
  return fit * clip;
}

/// Transform from clip to texture coordinates.
Eigen::Matrix4f texture_of_clip() {
  Eigen::Matrix4f m = Eigen::Matrix4f::Identity();
  m(0, 0) = m(1, 1) = m(0, 3) = m(1, 3) = 0.5F;
  return m;
}

}  // namespace

const Eigen::Vector3f kSun_world = Eigen::Vector3f(-0.62F, 0.28F, 0.80F).normalized();

const Eigen::Vector3f& sun_of(const PictureStyle& style) { return style.cut_above ? kHighSun : kSun_world; }

void set_mesh_uniforms(const Program& program, const Eigen::Matrix4f& clip_world, float cut_m) {
  program.use();
  program.set("u_clip_world", clip_world);
  program.set("u_cut_m", cut_m);
  program.set("u_leaf_growth", 0.0F);
  program.set("u_num_watched", 0);
}

void ShadowPainter::begin(int texels, const Eigen::Matrix4f& clip_world, float cut_m) {
  gl_.Viewport(0, 0, texels, texels);
  gl_.ClearDepth(1.0);
  gl_.DepthMask(GL_TRUE);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.DepthFunc(GL_LESS);
  gl_.Enable(GL_POLYGON_OFFSET_FILL);
  gl_.PolygonOffset(1.5F, 2.0F);
  set_mesh_uniforms(depth_program_, clip_world, cut_m);
}

void ShadowPainter::draw_world(const WorldPainter& world, const PictureStyle& style) {
  const float cut_m = cut_of(style);
  if (world_shadows_.contains(cut_m)) return;
  if (world_shadows_.size() >= kShadowsKept) {
    delete_target(gl_, world_shadows_.begin()->second.target);
    world_shadows_.erase(world_shadows_.begin());
  }

  Shadow shadow;
  Eigen::AlignedBox3f casters = world.casters_m();
  if (casters.isEmpty()) casters.extend(Eigen::Vector3f::Zero());
  casters.max().z() = std::max(casters.min().z(), std::min(casters.max().z(), cut_m));
  float width_m = 1.0F;
  const Eigen::Matrix4f clip_world = clip_of_sun(sun_of(style), casters, width_m);
  const int texels = std::clamp(static_cast<int>(width_m / kShadowTexel_m), 256, kMaxShadowTexels);
  shadow.target = make_target(gl_, texels, texels, {0, GL_DEPTH_COMPONENT16, 1, false, true});
  shadow.texture_world = texture_of_clip() * clip_world;
  shadow.texel_m = width_m / static_cast<float>(texels);

  begin(texels, clip_world, cut_m);
  gl_.Enable(GL_CLIP_DISTANCE0);
  DrawSelection selection;
  selection.frustum = frustum_of(clip_world);
  selection.parallel = true;
  selection.pixels_at_1m = 1.0F / shadow.texel_m;
  selection.cut_m = cut_m;
  world.draw(depth_program_, selection);
  gl_.Disable(GL_POLYGON_OFFSET_FILL);
  gl_.Disable(GL_CLIP_DISTANCE0);
  world_shadows_.emplace(cut_m, shadow);
}

void ShadowPainter::draw_vehicles(const VehiclePainter& vehicles, std::span<const float> radii_m,
                                  const PictureScene& picture, const PictureStyle& style) {
  if (vehicle_shadow_.target.framebuffer == 0) {
    vehicle_shadow_.target =
        make_target(gl_, kVehicleShadowTexels, kVehicleShadowTexels, {0, GL_DEPTH_COMPONENT32F, 1, false, true});
  }
  Eigen::AlignedBox3f box;
  for (std::size_t v = 0; v < std::min(picture.states.size(), radii_m.size()); ++v) {
    const Eigen::Vector3f p = picture.states[v].p_world_m.cast<float>();
    const float r = radii_m[v] * static_cast<float>(style.vehicle_scale);
    box.extend(Eigen::Vector3f(p.array() - r));
    box.extend(Eigen::Vector3f(p.array() + r));
  }
  if (box.isEmpty()) box.extend(Eigen::Vector3f::Zero());
  float width_m = 1.0F;
  const Eigen::Matrix4f clip_world = clip_of_sun(sun_of(style), box, width_m);
  vehicle_shadow_.texture_world = texture_of_clip() * clip_world;
  vehicle_shadow_.texel_m = width_m / kVehicleShadowTexels;

  gl_.BindFramebuffer(GL_FRAMEBUFFER, vehicle_shadow_.target.framebuffer);
  begin(kVehicleShadowTexels, clip_world, kNoCut_m);
  vehicles.draw(picture.states, style.vehicle_scale, kNoVehicle);
  gl_.Disable(GL_POLYGON_OFFSET_FILL);
}

}  // namespace swiftlet::sim
