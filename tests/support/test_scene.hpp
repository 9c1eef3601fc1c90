// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Small worlds for tests, one line per object: TestScene b; b.add_box(...); StaticScene s(b.scene()). Material 0 is
/// Lambertian with reflectivity 0.3; add_material() returns further ones.
class TestScene {
 public:
  TestScene() { scene_.materials.push_back({"gray", 0.3F, false, {0.5F, 0.5F, 0.5F}}); }

  std::uint32_t add_material(float reflectivity, bool retroreflective = false) {
    scene_.materials.push_back({"material", reflectivity, retroreflective, {0.5F, 0.5F, 0.5F}});
    return static_cast<std::uint32_t>(scene_.materials.size() - 1);
  }

  /// A quadrilateral by its corners in order.
  void add_wall(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c, const Eigen::Vector3f& d,
                SurfaceClass surface_class = SurfaceClass::kWall, std::uint16_t instance = 0,
                std::uint32_t material = 0) {
    add_mesh({a, b, c, d}, {{0, 1, 2}, {0, 2, 3}}, surface_class, instance, material);
  }

  void add_box(const Eigen::Vector3f& min, const Eigen::Vector3f& max, SurfaceClass surface_class = SurfaceClass::kWall,
               std::uint16_t instance = 0, std::uint32_t material = 0) {
    std::vector<Eigen::Vector3f> v;
    for (int i = 0; i < 8; ++i)
      v.emplace_back(i & 1 ? max.x() : min.x(), i & 2 ? max.y() : min.y(), i & 4 ? max.z() : min.z());
    add_mesh(v,
             {{0, 2, 3},
              {0, 3, 1},
              {4, 5, 7},
              {4, 7, 6},
              {0, 1, 5},
              {0, 5, 4},
              {2, 6, 7},
              {2, 7, 3},
              {0, 4, 6},
              {0, 6, 2},
              {1, 3, 7},
              {1, 7, 5}},
             surface_class, instance, material);
  }

  /// A sphere of `stacks` x 2 `stacks` quadrilaterals with its vertices on the sphere.
  void add_sphere(const Eigen::Vector3f& center, float radius_m, int stacks = 64,
                  SurfaceClass surface_class = SurfaceClass::kObject, std::uint16_t instance = 0,
                  std::uint32_t material = 0) {
    std::vector<Eigen::Vector3f> v;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    const int slices = 2 * stacks;
    for (int i = 0; i <= stacks; ++i) {
      for (int j = 0; j < slices; ++j) {
        const double polar = std::numbers::pi * i / stacks;
        const double azimuth = 2.0 * std::numbers::pi * j / slices;
        const Eigen::Vector3d unit(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                                   std::cos(polar));
        v.push_back(center + radius_m * unit.cast<float>());
      }
    }
    const auto index = [&](int i, int j) { return static_cast<std::uint32_t>(i * slices + j % slices); };
    for (int i = 0; i < stacks; ++i) {
      for (int j = 0; j < slices; ++j) {
        triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
        triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
      }
    }
    add_mesh(v, triangles, surface_class, instance, material);
  }

  void add_mesh(std::vector<Eigen::Vector3f> vertices_mesh_m, std::vector<std::array<std::uint32_t, 3>> triangles,
                SurfaceClass surface_class, std::uint16_t instance, std::uint32_t material) {
    for (const Eigen::Vector3f& v : vertices_mesh_m) scene_.bounds_m.extend(v.cast<double>());
    scene_.instances.push_back(
        {static_cast<std::uint32_t>(scene_.meshes.size()), Eigen::Affine3f::Identity(), instance});
    scene_.meshes.push_back(
        {std::move(vertices_mesh_m), std::move(triangles), material, surface_class, VehiclePart::kNone});
  }

  const Scene& scene() const { return scene_; }

 private:
  Scene scene_;
};

}  // namespace swiftlet::sim
