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

/// Internal to this room (and to its benchmarks): what hides behind the interfaces.
namespace swiftlet::sim {

struct ReleaseDevice {
  void operator()(RTCDeviceTy* device) const;
};
struct ReleaseScene {
  void operator()(RTCSceneTy* scene) const;
};
using EmbreeDevice = std::unique_ptr<RTCDeviceTy, ReleaseDevice>;
using EmbreeScene = std::unique_ptr<RTCSceneTy, ReleaseScene>;

/// What all triangles of one instance of a mesh have in common.
struct Surface {
  std::uint32_t material = 0;
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  std::uint16_t instance = 0;
  VehiclePart part = VehiclePart::kNone;
};

/// What a hit needs to know of a triangle, in half a cache line. exact_hits_internal.hpp tells the rule that it serves.
struct alignas(32) Facet {
  Eigen::Vector3f corner_m;
  Eigen::Vector3f normal;            ///< unit vector; zero where the triangle has no area
  float least_cosine_per_m = 0.0F;   ///< visible from the range r where |cos| >= this * (r + 1 m)
  std::uint32_t surface : 24 = 0;    ///< index in TriangleScene::surfaces
  std::uint32_t firm_steps : 8 = 0;  ///< twice the margin as a barycentric distance, in 1/512; 255: never sure
};
static_assert(sizeof(Facet) == 32);

/// Triangles in one Embree geometry. Embree holds them a little enlarged; exact_hits_internal.hpp tells why.
struct TriangleScene {
  std::vector<std::array<Eigen::Vector3f, 3>> corners_m;
  std::vector<Facet> facets;  ///< of the same triangles; commit() fills in all but the surface
  std::vector<Surface> surfaces;
  std::vector<std::array<Eigen::Vector3f, 3>> enlarged_m;  ///< shared with Embree; made by commit()
  float slack_m = 0.0F;  ///< a ray goes on so far behind a proposal, beside a part of its range
  EmbreeScene scene;
  mutable EmbreeScene for_scattered_rays;  ///< the same triangles in a tree that suits them better; made when asked for

  std::size_t size() const { return corners_m.size(); }
  /// Builds the acceleration structure on all cores. The triangles must not change afterwards.
  void commit(RTCDeviceTy* device);
  /// The same for triangles that will move: prepare_for_exact_hits() must have been called.
  void commit_to_move(RTCDeviceTy* device);
  /// After all three lists of corners have moved alike: the tree stays, its boxes change.
  void refit();
  /// After commit(). Takes as long as that once more, and as much memory for a tree.
  void commit_for_scattered_rays(RTCDeviceTy* device) const;
};

/// Leaves that move in wind, where they hang, and the rest of the world without them.
struct Foliage {
  explicit Foliage(const FoliageMotion& of_world) : motion(of_world) {}

  FoliageMotion motion;
  TriangleScene rest;                    ///< its leaves; only those that move
  std::vector<float> share_of_sway;      ///< of each of these triangles
  std::vector<std::uint32_t> tree, way;  ///< of each, as FoliageMotion has them
  std::uint32_t num_trees = 0;
  TriangleScene firm;  ///< the rest of the world
};

/// A vehicle without its rotors, in its body frame; the rotors are met analytically (sweep_scene.cpp).
struct VehicleBody {
  TriangleScene triangles;
};

struct StaticScene::Impl {
  EmbreeDevice device;
  TriangleScene world;                     ///< all of it, with the leaves where they hang
  std::unique_ptr<const Foliage> foliage;  ///< null: nothing moves
  Eigen::AlignedBox3d bounds_m;

  /// The body of a shape ready to trace; vehicles of one shape share it, whoever asks.
  /// @param with_sensors  false: as seen from aboard. The housing on top stands for the very sensor that looks.
  std::shared_ptr<const VehicleBody> body_of(const std::shared_ptr<const VehicleShape>& shape, bool with_sensors) const;
  /// ExactQuery::trace_scattered() is worth it from here on.
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
