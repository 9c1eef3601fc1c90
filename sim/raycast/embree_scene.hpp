// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/world/foliage.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

struct RTCDeviceTy;
struct RTCSceneTy;

/// Internal to sim/raycast (and its benchmarks): implementation behind the interfaces.
namespace swiftlet::sim {

struct ReleaseDevice {
  void operator()(RTCDeviceTy* device) const;
};
struct ReleaseScene {
  void operator()(RTCSceneTy* scene) const;
};
using EmbreeDevice = std::unique_ptr<RTCDeviceTy, ReleaseDevice>;
using EmbreeScene = std::unique_ptr<RTCSceneTy, ReleaseScene>;

/// Properties common to all triangles of one instance of a mesh.
struct Surface {
  std::uint32_t material = 0;
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  std::uint16_t instance = 0;
  VehiclePart part = VehiclePart::kNone;
};

/// Data of a triangle for hit evaluation, in half a cache line. exact_hits_internal.hpp defines the rule.
struct alignas(32) Facet {
  Eigen::Vector3f corner_m;
  Eigen::Vector3f normal;           ///< unit vector; zero for a degenerate triangle
  float least_cosine_per_m = 0.0F;  ///< visible from range r if |cos| >= this * (r + 1 m)
  std::uint32_t surface : 24 = 0;   ///< index in TriangleScene::surfaces
  /// Twice the margin as a barycentric distance, in 1/512; 255: always tested in full
  std::uint32_t firm_steps : 8 = 0;
};
static_assert(sizeof(Facet) == 32);

/// Triangles in one Embree geometry. Embree holds them slightly enlarged; see exact_hits_internal.hpp.
struct TriangleScene {
  std::vector<std::array<Eigen::Vector3f, 3>> corners_m;
  std::vector<Facet> facets;  ///< one per triangle; commit() fills in all but the surface
  std::vector<Surface> surfaces;
  std::vector<std::array<Eigen::Vector3f, 3>> enlarged_m;  ///< shared with Embree; created by commit()
  /// Absolute part of the distance that a ray continues beyond a proposal; another part grows with its range
  float slack_m = 0.0F;
  EmbreeScene scene;
  mutable EmbreeScene for_scattered_rays;  ///< copy in a tree optimized for scattered rays; created on demand

  std::size_t size() const { return corners_m.size(); }
  /// Builds the acceleration structure on all cores. The triangles must not change afterwards.
  void commit(RTCDeviceTy* device);
  /// As commit(), for triangles that will move; requires prepare_for_exact_hits().
  void commit_to_move(RTCDeviceTy* device);
  /// Call after all three lists of corners have moved alike: keeps the tree and updates its boxes.
  void refit();
  /// Call after commit(). Doubles construction time and memory.
  void commit_for_scattered_rays(RTCDeviceTy* device) const;
};

/// Leaves that move in wind, at their rest positions, and the rest of the world.
struct Foliage {
  explicit Foliage(const FoliageMotion& of_world) : motion(of_world) {}

  FoliageMotion motion;
  TriangleScene rest;                        ///< the moving leaves at rest
  std::vector<float> share_of_sway;          ///< one per triangle of `rest`
  std::vector<std::uint32_t> tree, pattern;  ///< one per triangle of `rest`, arguments of FoliageMotion
  std::uint32_t num_trees = 0;
  TriangleScene firm;  ///< the rest of the world
};

/// A vehicle without its rotors, in its body frame; rotors are intersected analytically (sweep_scene.cpp).
struct VehicleBody {
  TriangleScene triangles;
};

struct StaticScene::Impl {
  EmbreeDevice device;
  TriangleScene world;                     ///< the whole world, with leaves at rest
  std::unique_ptr<const Foliage> foliage;  ///< null: nothing moves
  Eigen::AlignedBox3d bounds_m;

  /// Ray-tracing structure of a vehicle's body, shared by all vehicles of one shape.
  /// @param with_sensors  false: for the vehicle's own sensor, which its housing does not block
  std::shared_ptr<const VehicleBody> body_of(const std::shared_ptr<const VehicleShape>& shape, bool with_sensors) const;
  /// Builds the tree for ExactQuery::trace_scattered().
  void expect_scattered_rays() const;

 private:
  struct CachedBody {
    std::weak_ptr<const VehicleShape> shape;
    std::weak_ptr<const VehicleBody> body;
  };
  mutable std::mutex mutex_;
  mutable std::map<std::pair<const VehicleShape*, bool>, CachedBody> bodies_;
};

}  // namespace swiftlet::sim
