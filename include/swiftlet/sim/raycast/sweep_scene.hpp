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

inline constexpr int kPacketSize = 16;

/// Beams that leave one point at one instant share a firing; each beam names its firing.
struct Firing {
  float offset_s = 0.0F;  ///< after the start of the sweep
  Eigen::Vector3f origin_lidar_m = Eigen::Vector3f::Zero();
};

/// 16 beams in the lidar frame, structure of arrays. Beams of one packet should lie close together.
struct alignas(64) BeamPacket {
  std::array<float, kPacketSize> direction_x, direction_y, direction_z;  ///< unit vectors
  std::array<std::int32_t, kPacketSize> firing;                          ///< index; lanes that are not used: any valid
};

/// What the beams of a packet met. The surface is an index in SweepScene::surfaces().
struct alignas(64) PacketHits {
  std::array<float, kPacketSize> range_m;        ///< 0: nothing
  std::array<float, kPacketSize> cos_incidence;  ///< |cos| of the angle between beam and normal
  std::array<std::uint32_t, kPacketSize> surface;
};

/// Everything that beams may tell apart, static world first, then vehicle by vehicle.
struct SweepSurface {
  std::uint32_t material = 0;  ///< in Scene::materials, or in the VehicleShape's for vehicles
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  std::uint16_t instance = 0;  ///< VehicleId + 1 for vehicles
  VehiclePart part = VehiclePart::kNone;
  VehicleId vehicle = kNoVehicle;
};

/// The world as one moving sensor sees it during a sweep: the static scene and all vehicles, each at the instant of
/// each beam. Rotors are met where a blade is at that very instant. One per sensor; trace() is thread-safe.
///
/// Leaves that move in wind are met where they are in the middle of the sweep. Without wind
/// nothing is rebuilt between sweeps. The static scene is traced in the world frame. Rays are carried into the body
/// frame of a vehicle, which few packets come near. Blades are met analytically, in their disc. Motion is that of
/// StateHistory, sampled every 2 ms and interpolated linearly in between (error below a h^2 / 8 = 0.01 mm at 20 m/s^2).
class SweepScene {
 public:
  /// @param shapes        by VehicleId
  /// @param self          the vehicle that carries the sensor
  /// @param range_max_m   nothing beyond is met
  SweepScene(std::shared_ptr<const StaticScene> world, std::vector<std::shared_ptr<const VehicleShape>> shapes,
             VehicleId self, const Pose& T_body_lidar, double range_max_m);
  ~SweepScene();
  SweepScene(const SweepScene&) = delete;
  SweepScene& operator=(const SweepScene&) = delete;

  /// Instants and origins of the beams, until told otherwise.
  /// @param coherent  beams of one packet go in nearly the same direction: they are traced together, otherwise one by
  /// one
  void set_firings(std::span<const Firing> firings, bool coherent = true);
  /// Looks up where everything is during [start, start + duration]. duration 0 freezes all in `start`.
  /// Allocates nothing.
  void begin(const StateHistory& truth, TimeNs start, TimeNs duration);

  /// The nearest surface along each beam.
  /// @param meets_self  false promises that no beam of the packet meets the own vehicle (reaches_self() was 0)
  void trace(const BeamPacket& beams, bool meets_self, PacketHits& hits) const;
  /// Bit i: beam i can meet the own vehicle, rotor discs taken as whole. Does not depend on begin().
  std::uint32_t reaches_self(const BeamPacket& beams) const;

  std::span<const SweepSurface> surfaces() const;
  /// Pose of the sensor at a firing of the current sweep.
  const Pose& T_world_lidar(int firing) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace swiftlet::sim
