// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {

/// [-] Beams that are traced together; the width of the widest vector instructions.
inline constexpr int kPacketSize = 16;

/// Beams from one origin at one instant share a firing; each beam refers to its firing.
struct Firing {
  float offset_s = 0.0F;  ///< time after the start of the sweep
  Eigen::Vector3f origin_lidar_m = Eigen::Vector3f::Zero();
};

/// 16 beams in the lidar frame, structure of arrays. Beams of one packet should be close in direction.
struct alignas(64) BeamPacket {
  std::array<float, kPacketSize> direction_x, direction_y, direction_z;  ///< unit vectors
  std::array<std::int32_t, kPacketSize> firing;                          ///< index; in unused lanes any valid one
};

/// Intersections of a packet. The surface is an index in SweepScene::surfaces().
struct alignas(64) PacketHits {
  std::array<float, kPacketSize> range_m;        ///< 0: no intersection
  std::array<float, kPacketSize> cos_incidence;  ///< |cos| of the angle between beam and normal
  std::array<std::uint32_t, kPacketSize> surface;
};

/// Distinguishable surfaces, the static world's first, then vehicle by vehicle.
struct SweepSurface {
  std::uint32_t material = 0;  ///< in Scene::materials, or in the VehicleShape's for vehicles
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  std::uint16_t instance = 0;  ///< VehicleId + 1 for vehicles
  VehiclePart part = VehiclePart::kNone;
  VehicleId vehicle = kNoVehicle;
};

/// The world as one moving sensor observes it during a sweep: the static scene and all vehicles, each at the instant of
/// each beam. Rotor blades are intersected at their angle at that instant. One per sensor; trace() is thread-safe.
///
/// Waving leaves are placed at the middle of the sweep; without wind nothing is rebuilt between sweeps. The static
/// scene is traced in the world frame. For the few packets that come near a vehicle, rays are transformed into its body
/// frame. Blades are intersected analytically in their disc. Motion is that of StateHistory, sampled every 2 ms and
/// interpolated linearly in between (error below a h^2 / 8 = 0.01 mm at 20 m/s^2).
class SweepScene {
 public:
  /// @param shapes  indexed by VehicleId
  /// @param self  carrier of the sensor
  /// @param range_max_m  largest range of an intersection
  SweepScene(std::shared_ptr<const StaticScene> world, std::vector<std::shared_ptr<const VehicleShape>> shapes,
             VehicleId self, const Pose& T_body_lidar, double range_max_m);
  ~SweepScene();
  SweepScene(const SweepScene&) = delete;
  SweepScene& operator=(const SweepScene&) = delete;

  /// Sets instants and origins of the beams; they hold until the next call.
  /// @param coherent  beams of a packet have similar directions and are traced together; false: one by one
  void set_firings(std::span<const Firing> firings, bool coherent = true);
  /// Samples all poses during [start, start + duration]. duration 0 freezes all poses at `start`.
  /// Allocates nothing.
  void begin(const StateHistory& truth, TimeNs start, TimeNs duration);

  /// The nearest surface along each beam.
  /// @param meets_self  false asserts that no beam of the packet can intersect the own vehicle (reaches_self() was 0)
  void trace(const BeamPacket& beams, bool meets_self, PacketHits& hits) const;
  /// Bit i: beam i can intersect the own vehicle, with full rotor discs. Does not depend on begin().
  std::uint32_t reaches_self(const BeamPacket& beams) const;

  std::span<const SweepSurface> surfaces() const;
  /// Pose of the sensor at a firing of the current sweep.
  const Pose& T_world_lidar(int firing) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace swiftlet::sim
