// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "swiftlet/sim/physics/physics_world.hpp"

namespace swiftlet::sim {

class Contacts;

/// Reason why a vehicle does not fit at a position.
struct NoRoom {
  double depth_m = 0.0;  ///< penetration of the hull into the surface; 0: the whole vehicle is below the ground
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  double free_z_m = 0.0;  ///< least collision-free height at the same x and y
};

/// Checks whether vehicles collide with the static world at their start positions and destinations. Uses the exact
/// collision shapes and the attitude of the start. A closed solid, other than the ground, that is much larger than the
/// vehicle and contains it cannot be distinguished from a hall.
class FreePlaces {
 public:
  FreePlaces(std::span<const PhysicsVehicle> vehicles, const PhysicsConfig& config, const StaticScene& world);
  ~FreePlaces();

  /// Empty when vehicle number `i` fits at the position; legs may penetrate uneven ground slightly.
  std::optional<NoRoom> check(std::size_t i, const Vector3& p_world_m);

 private:
  std::optional<NoRoom> no_room_at(std::size_t i, const Vector3& p_world_m, double tolerance_m);
  bool is_below_ground(const Vector3& p_world_m) const;

  std::span<const PhysicsVehicle> vehicles_;
  const StaticScene& world_;
  std::unique_ptr<Contacts> contacts_;
};

}  // namespace swiftlet::sim
