// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "swiftlet/sim/physics/physics_world.hpp"

namespace swiftlet::sim {

class Contacts;

/// Why a vehicle cannot be at a place.
struct NoRoom {
  double depth_m = 0.0;  ///< of its hull in the surface; 0: it is as a whole below the ground
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  double free_z_m = 0.0;  ///< least height above the place, at the same x and y, at which there is room
};

/// Looks whether vehicles have room in the static world where they start or are meant to go. Uses the shapes of the
/// contacts, exactly, and the attitude of the start. A solid thing that is much larger than the vehicle and holds
/// it as a whole is not told from a hall, except the ground.
class FreePlaces {
 public:
  FreePlaces(std::span<const PhysicsVehicle> vehicles, const PhysicsConfig& config, const StaticScene& world);
  ~FreePlaces();

  /// Nothing when there is room for vehicle number `i` at the place; legs may stand a little into uneven ground.
  std::optional<NoRoom> check(std::size_t i, const Vector3& p_world_m);

 private:
  std::optional<NoRoom> no_room_at(std::size_t i, const Vector3& p_world_m, double tolerance_m);
  bool is_below_ground(const Vector3& p_world_m) const;

  std::span<const PhysicsVehicle> vehicles_;
  const StaticScene& world_;
  std::unique_ptr<Contacts> contacts_;
};

}  // namespace swiftlet::sim
