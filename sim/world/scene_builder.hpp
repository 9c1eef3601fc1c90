// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>

#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Puts a Scene together: materials by name, truth instance numbers by class, bounds at the end.
class SceneBuilder {
 public:
  /// Adds the mesh without showing it; place() does. Returns its index.
  std::uint32_t add_mesh(Mesh mesh, const Material& material, SurfaceClass surface_class);
  void place(std::uint32_t mesh, std::uint16_t instance, const Eigen::Affine3f& T_world_mesh);
  /// add_mesh and place of a mesh made in world coordinates. An empty mesh is left out.
  void add(Mesh mesh, const Material& material, SurfaceClass surface_class, std::uint16_t instance = 0);

  /// 1, 2, 3, ... for each class; throws InputError beyond the 65535 that a label can hold.
  std::uint16_t next_instance(SurfaceClass surface_class);
  void add_object(WorldObject object);

  /// What is placed from now on surrounds the place: it counts for the height of the bounds only.
  void begin_surroundings() { num_within_ = scene_.instances.size(); }

  /// Leaves move in wind; without this they hang still.
  void move_foliage(const FoliageConfig& foliage, std::uint64_t seed);

  /// The scene with its bounds. The builder is empty afterwards.
  Scene finish();

 private:
  std::uint32_t index_of(const Material& material);

  Scene scene_;
  std::optional<std::size_t> num_within_;  // instances of the place itself
  std::map<SurfaceClass, std::uint16_t> last_instance_;
};

/// From the axes of a file to the world, in double precision: scale, turn about the vertical, then shift.
Eigen::Affine3d placement(const Eigen::Vector3d& position_world_m, double yaw_deg, double scale);

/// Turn about the vertical, then shift.
Eigen::Affine3f transform(const Eigen::Vector3f& position_world_m, float yaw_rad = 0.0F,
                          const Eigen::Vector3f& scale = Eigen::Vector3f::Ones());

}  // namespace swiftlet::sim
