// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "swiftlet/sim/physics/physics_world.hpp"

namespace swiftlet::sim {

/// State of one vehicle that may touch something in this step. Pose at the beginning of the step, velocities at its end
/// in free flight; resolve() applies the contacts.
struct ContactBody {
  VehicleId vehicle = kNoVehicle;
  bool near_world = false;  ///< test against the triangles of gather_triangles()
  Vector3 p_world_m = Vector3::Zero();
  Eigen::Quaterniond q_world_body = Eigen::Quaterniond::Identity();
  Vector3 v_world_mps = Vector3::Zero();
  Vector3 omega_world_radps = Vector3::Zero();
  bool touched = false;  ///< output: a contact applied an impulse
};

struct Touch {
  VehicleId vehicle = kNoVehicle;
  VehicleId other = kNoVehicle;  ///< kNoVehicle: the static world
  Vector3 p_world_m = Vector3::Zero();
  double approach_mps = 0.0;     ///< normal speed before the contact impulse, positive when closing
  bool propeller = false;        ///< the contact is at this vehicle's propeller disc
  bool other_propeller = false;  ///< the contact is at the other vehicle's propeller disc
};

/// Narrow phase and contact impulses by Bullet; only contacts.cpp includes Bullet's headers.
///
/// There is no broad phase and no second BVH. The caller determines possible contacts from exact distances and provides
/// the triangles of StaticScene (Embree) near a vehicle. A vehicle's shape is a compound of the body (cylinder), arms
/// (boxes), legs (capsules) and propeller discs (cylinders).
class Contacts {
 public:
  Contacts(std::span<const PhysicsVehicle> vehicles, const PhysicsConfig& config);
  ~Contacts();

  /// Radius of the collision shape about the center of mass [m].
  double reach_m(VehicleId vehicle) const;
  /// Stores the triangles near `box_world` as this vehicle's possible contacts until the next call.
  void gather_triangles(VehicleId vehicle, const StaticScene& scene, const Eigen::AlignedBox3d& box_world);

  struct Overlap {
    double depth_m = 0.0;  ///< 0: no penetration
    Vector3 p_world_m = Vector3::Zero();
  };
  /// The deepest contact of the vehicle's shape, at this pose, with the triangles of gather_triangles().
  Overlap overlap(VehicleId vehicle, const Vector3& p_world_m, const Eigen::Quaterniond& q_world_body);

  struct Pair {
    VehicleId a = kNoVehicle;  ///< a < b; both in `bodies`
    VehicleId b = kNoVehicle;
  };
  /// Solves one step of contact impulses. `touches` receives every contact with an impulse, once for each vehicle in
  /// it.
  void resolve(std::span<ContactBody> bodies, std::span<const Pair> pairs, std::vector<Touch>& touches);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace swiftlet::sim
