// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "swiftlet/sim/world/scene.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// Intersection of a ray. `vehicle` is kNoVehicle for the static world.
struct RayHit {
  float range_m = 0.0F;        ///< 0: no intersection
  float cos_incidence = 0.0F;  ///< |cos| of the angle between ray and normal
  std::uint32_t material = 0;  ///< index in Scene::materials, or in VehicleShape's for vehicles
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  std::uint16_t instance = 0;  ///< truth instance; VehicleId + 1 for a vehicle
  VehicleId vehicle = kNoVehicle;
  VehiclePart part = VehiclePart::kNone;
};

/// Nearest surface point of the static world.
struct NearestSurface {
  double distance_m = 0.0;
  Vector3 point_world_m = Vector3::Zero();
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  std::uint16_t instance = 0;
};

/// The static world as a ray-tracing structure. Immutable after construction, shared by sensors, physics, radio and the
/// worlds of a batch; every method is const and thread-safe. Hides Embree.
class StaticScene {
 public:
  explicit StaticScene(const Scene& scene);
  ~StaticScene();
  StaticScene(const StaticScene&) = delete;
  StaticScene& operator=(const StaticScene&) = delete;

  std::size_t num_triangles() const;
  const Eigen::AlignedBox3d& bounds_m() const;

  /// One ray, for radio, altimeters and tests. `direction` is a unit vector.
  RayHit trace(const Vector3& origin_world, const Vector3& direction_world, double range_max_m) const;
  /// True if a surface lies strictly between a and b.
  bool occluded(const Vector3& a_world, const Vector3& b_world) const;
  /// Exact distance to the nearest triangle, by a BVH point query; nullopt when none is nearer than max_distance_m.
  std::optional<NearestSurface> nearest(const Vector3& p_world, double max_distance_m) const;
  /// Calls visit(a, b, c, triangle_index) for every triangle whose bounding box touches the box, in order of the index.
  void triangles_near_box(const Eigen::AlignedBox3d& box_world,
                          const std::function<void(const Vector3&, const Vector3&, const Vector3&, int)>& visit) const;

  struct Impl;  // used only within sim/raycast
  const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace swiftlet::sim
