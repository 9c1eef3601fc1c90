// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "sim/raycast/ray_scene.hpp"

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

/// Triangles in one Embree geometry with one surface number per triangle. The arrays are shared with Embree.
struct TriangleScene {
  std::vector<Eigen::Vector3f> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> surface_of_triangle;
  std::vector<Surface> surfaces;
  EmbreeScene scene;

  /// Builds the acceleration structure on all cores. The arrays must not change afterwards.
  void commit(RTCDeviceTy* device);
};

/// A vehicle without its rotors, in its body frame; the rotors are met analytically (sweep_scene.cpp).
struct VehicleBody {
  TriangleScene triangles;
};

struct StaticScene::Impl {
  EmbreeDevice device;
  TriangleScene world;
  Eigen::AlignedBox3d bounds_m;

  /// The body of a shape ready to trace; vehicles of one shape share it, whoever asks.
  /// @param with_sensors  false: as seen from aboard. The housing on top stands for the very sensor that looks.
  std::shared_ptr<const VehicleBody> body_of(const std::shared_ptr<const VehicleShape>& shape, bool with_sensors) const;

 private:
  struct CachedBody {
    std::weak_ptr<const VehicleShape> shape;
    std::weak_ptr<const VehicleBody> body;
  };
  mutable std::mutex mutex_;
  mutable std::map<std::pair<const VehicleShape*, bool>, CachedBody> bodies_;
};

}  // namespace swiftlet::sim
