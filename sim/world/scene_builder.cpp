// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/scene_builder.hpp"

#include <limits>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {

std::uint32_t SceneBuilder::index_of(const Material& material) {
  for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
    if (scene_.materials[i].name == material.name) return static_cast<std::uint32_t>(i);
  }
  scene_.materials.push_back(material);
  return static_cast<std::uint32_t>(scene_.materials.size() - 1);
}

std::uint32_t SceneBuilder::add_mesh(Mesh mesh, const Material& material, SurfaceClass surface_class) {
  mesh.material = index_of(material);
  mesh.surface_class = surface_class;
  scene_.meshes.push_back(std::move(mesh));
  return static_cast<std::uint32_t>(scene_.meshes.size() - 1);
}

void SceneBuilder::place(std::uint32_t mesh, std::uint16_t instance, const Eigen::Affine3f& T_world_mesh) {
  if (scene_.meshes[mesh].triangles.empty()) return;
  scene_.instances.push_back({mesh, T_world_mesh, instance});
}

void SceneBuilder::add(Mesh mesh, const Material& material, SurfaceClass surface_class, std::uint16_t instance) {
  if (mesh.triangles.empty()) return;
  place(add_mesh(std::move(mesh), material, surface_class), instance, Eigen::Affine3f::Identity());
}

std::uint16_t SceneBuilder::next_instance(SurfaceClass surface_class) {
  std::uint16_t& last = last_instance_[surface_class];
  if (last == std::numeric_limits<std::uint16_t>::max()) {
    throw InputError(std::string("world: expected at most 65535 things of class '") + name_of(surface_class) +
                     "', found more");
  }
  return ++last;
}

void SceneBuilder::add_object(WorldObject object) { scene_.objects.push_back(std::move(object)); }

void SceneBuilder::move_foliage(const FoliageConfig& foliage, std::uint64_t seed) {
  scene_.foliage = foliage;
  scene_.foliage_seed = seed;
}

Scene SceneBuilder::finish() {
  // Meshes that are never placed are removed.
  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> new_index(scene_.meshes.size(), kUnused);
  std::vector<Mesh> used;
  for (Instance& instance : scene_.instances) {
    std::uint32_t& index = new_index[instance.mesh];
    if (index == kUnused) {
      index = static_cast<std::uint32_t>(used.size());
      used.push_back(std::move(scene_.meshes[instance.mesh]));
    }
    instance.mesh = index;
  }
  scene_.meshes = std::move(used);

  Eigen::AlignedBox3d everything_m;
  for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
    const Instance& instance = scene_.instances[i];
    for (const Eigen::Vector3f& vertex : scene_.meshes[instance.mesh].vertices_mesh_m) {
      everything_m.extend((instance.T_world_mesh * vertex).cast<double>());
    }
    if (i + 1 == num_within_) scene_.bounds_m = everything_m;
  }
  if (scene_.bounds_m.isEmpty()) scene_.bounds_m = everything_m;
  scene_.bounds_m.min().z() = everything_m.min().z();
  scene_.bounds_m.max().z() = everything_m.max().z();
  Scene scene = std::move(scene_);
  *this = {};
  return scene;
}

Eigen::Affine3d placement(const Eigen::Vector3d& position_world_m, double yaw_deg, double scale) {
  Eigen::Affine3d T = Eigen::Affine3d::Identity();
  T.translate(position_world_m).rotate(Eigen::AngleAxisd(radians(yaw_deg), Eigen::Vector3d::UnitZ())).scale(scale);
  return T;
}

Eigen::Affine3f transform(const Eigen::Vector3f& position_world_m, float yaw_rad, const Eigen::Vector3f& scale) {
  Eigen::Affine3f T = Eigen::Affine3f::Identity();
  T.translate(position_world_m).rotate(Eigen::AngleAxisf(yaw_rad, Eigen::Vector3f::UnitZ())).scale(scale);
  return T;
}

}  // namespace swiftlet::sim
