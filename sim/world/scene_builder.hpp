// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>

#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Assembles a Scene: materials by name, truth instance numbers by class, bounds at the end.
class SceneBuilder {
 public:
  /// Adds a mesh without placing it; place() does. Returns its index.
  std::uint32_t add_mesh(Mesh mesh, const Material& material, SurfaceClass surface_class);
  void place(std::uint32_t mesh, std::uint16_t instance, const Eigen::Affine3f& T_world_mesh);
  /// Adds and places a mesh in world coordinates. An empty mesh is ignored.
  void add(Mesh mesh, const Material& material, SurfaceClass surface_class, std::uint16_t instance = 0);

  /// Next number of a class: 1, 2, 3, ...; throws InputError beyond 65535, the largest label.
  std::uint16_t next_instance(SurfaceClass surface_class);
  void add_object(WorldObject object);

  /// Instances placed from now on are surroundings: they extend only the height of the bounds.
  void begin_surroundings() { num_within_ = scene_.instances.size(); }

  /// Enables motion of leaves in wind.
  void move_foliage(const FoliageConfig& foliage, std::uint64_t seed);

  /// Returns the scene with its bounds. The builder is empty afterwards.
  Scene finish();

 private:
  std::uint32_t index_of(const Material& material);

  Scene scene_;
  std::optional<std::size_t> num_within_;  // number of instances before the surroundings
  std::map<SurfaceClass, std::uint16_t> last_instance_;
};

/// Transform from file axes to the world, in double precision: scale, rotation about the vertical, translation.
Eigen::Affine3d placement(const Eigen::Vector3d& position_world_m, double yaw_deg, double scale);

/// Rotation about the vertical and translation.
Eigen::Affine3f transform(const Eigen::Vector3f& position_world_m, float yaw_rad = 0.0F,
                          const Eigen::Vector3f& scale = Eigen::Vector3f::Ones());

}  // namespace swiftlet::sim
