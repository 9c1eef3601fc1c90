// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "sim/render/canvas.hpp"
#include "sim/render/renderer.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {

/// A scene of boxes.
class BoxWorld {
 public:
  BoxWorld& add(const Eigen::Vector3f& min_m, const Eigen::Vector3f& max_m, const Eigen::Vector3f& color_rgb,
                SurfaceClass surface_class = SurfaceClass::kObject) {
    Mesh mesh;
    mesh.surface_class = surface_class;
    mesh.material = static_cast<std::uint32_t>(scene_.materials.size());
    add_box(mesh, min_m, max_m);
    scene_.materials.push_back({"paint", 0.5F, false, color_rgb});
    scene_.instances.push_back({static_cast<std::uint32_t>(scene_.meshes.size()), Eigen::Affine3f::Identity(), 0});
    scene_.meshes.push_back(std::move(mesh));
    scene_.bounds_m.extend(min_m.cast<double>());
    scene_.bounds_m.extend(max_m.cast<double>());
    return *this;
  }
  Scene& scene() { return scene_; }

 private:
  Scene scene_;
};

/// Square leaves side by side at x = 5 m: an upright square of as many a side, from `low_z_m` on, about y = 0.
inline Scene leaf_wall(float leaf_m, int leaves_a_side, float low_z_m) {
  Scene scene;
  scene.materials.push_back({"leaves", 0.5F, false, {0.1F, 0.7F, 0.1F}});
  Mesh leaves;
  leaves.surface_class = SurfaceClass::kVegetation;
  const float side_m = leaf_m * static_cast<float>(leaves_a_side), reach_m = leaf_m + 0.01F;
  for (int i = 0; i < leaves_a_side * leaves_a_side; ++i) {
    const Eigen::Vector3f at(5, leaf_m * static_cast<float>(i % leaves_a_side) - 0.5F * side_m,
                             leaf_m * static_cast<float>(i / leaves_a_side) + low_z_m);
    add_quad(leaves, at, at + Eigen::Vector3f(0, reach_m, 0), at + Eigen::Vector3f(0, reach_m, reach_m),
             at + Eigen::Vector3f(0, 0, reach_m));
  }
  scene.meshes.push_back(leaves);
  scene.instances.push_back({0, Eigen::Affine3f::Identity(), 1});
  scene.bounds_m = Eigen::AlignedBox3d(Eigen::Vector3d(5, -0.5 * side_m, low_z_m),
                                       Eigen::Vector3d(5, 0.5 * side_m, low_z_m + side_m));
  return scene;
}

/// A body of half a meter with one rotor on top.
inline std::shared_ptr<const VehicleShape> make_test_shape() {
  auto shape = std::make_shared<VehicleShape>();
  Mesh body;
  body.part = VehiclePart::kBody;
  add_box(body, Eigen::Vector3f(-0.25F, -0.25F, -0.25F), Eigen::Vector3f(0.25F, 0.25F, 0.25F));
  shape->materials.push_back({"frame", 0.3F, false, {0.2F, 0.2F, 0.2F}});
  shape->meshes.push_back(body);
  shape->rotors.push_back({{0.0F, 0.0F, 0.4F}, 1.0F, 2, 0.05F, 1.0F});
  shape->circumscribed_radius_m = 1.1F;
  return shape;
}

/// Image of a figure with one painter.
inline Image painted(int width_px, int height_px, const Rgb& page, std::function<void(Canvas&)> paint) {
  return Figure{width_px, height_px, std::move(paint)}.pixels(page);
}

/// Channel values 0..1 of a pixel.
inline Rgb color_at(const Image& image, int x, int y) {
  const std::uint8_t* p = image.pixel(x, y);
  return Rgb(p[0], p[1], p[2]) / 255.0F;
}
inline float brightness(const Rgb& color) { return color.sum() / 3.0F; }

/// Is one channel far above the others?
inline bool is_dominated_by(const Rgb& color, int channel) {
  for (int c = 0; c < 3; ++c) {
    if (c != channel && color[channel] < color[c] + 0.2F) return false;
  }
  return true;
}

}  // namespace swiftlet::sim
