// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "swiftlet/sim/physics/physics_world.hpp"

namespace swiftlet::sim {

/// One vehicle that may touch something in this step. Pose at the beginning of the step, velocities as free flight
/// leaves them at its end; resolve() changes what the contacts change.
struct ContactBody {
  VehicleId vehicle = kNoVehicle;
  bool near_world = false;  ///< test it against the triangles of gather_triangles()
  Vector3 p_world_m = Vector3::Zero();
  Eigen::Quaterniond q_world_body = Eigen::Quaterniond::Identity();
  Vector3 v_world_mps = Vector3::Zero();
  Vector3 omega_world_radps = Vector3::Zero();
  bool touched = false;  ///< out: a contact pushed it
};

struct Touch {
  VehicleId vehicle = kNoVehicle;
  VehicleId other = kNoVehicle;  ///< kNoVehicle: the static world
  Vector3 p_world_m = Vector3::Zero();
  double approach_mps = 0.0;     ///< normal speed before the contact acted, positive when closing
  bool propeller = false;        ///< this vehicle's propeller disc is what touches
  bool other_propeller = false;  ///< the other vehicle's propeller disc is what is touched
};

/// Narrow phase and contact impulses by Bullet; the only file with its headers is contacts.cpp.
///
/// There is no broad phase and no second BVH. The caller knows from exact distances who can touch what, and hands over
/// the triangles that StaticScene (Embree) has near a vehicle. A vehicle's shape is a compound of the body (cylinder),
/// arms (boxes), legs (capsules) and propeller discs (cylinders).
class Contacts {
 public:
  Contacts(std::span<const PhysicsVehicle> vehicles, const PhysicsConfig& config);
  ~Contacts();

  /// Radius about the center of mass that holds the collision shape [m].
  double reach_m(VehicleId vehicle) const;
  /// Keeps the triangles that may touch `box_world` as what this vehicle can meet until the next call.
  void gather_triangles(VehicleId vehicle, const StaticScene& scene, const Eigen::AlignedBox3d& box_world);

  struct Overlap {
    double depth_m = 0.0;  ///< 0: touches nothing, or merely touches
    Vector3 p_world_m = Vector3::Zero();
  };
  /// The deepest contact of the vehicle's shape, put there, with the triangles of gather_triangles().
  Overlap overlap(VehicleId vehicle, const Vector3& p_world_m, const Eigen::Quaterniond& q_world_body);

  struct Pair {
    VehicleId a = kNoVehicle;  ///< a < b; both in `bodies`
    VehicleId b = kNoVehicle;
  };
  /// One step of contact impulses. `touches` receives every contact that pushed, once for each vehicle in it.
  void resolve(std::span<ContactBody> bodies, std::span<const Pair> pairs, std::vector<Touch>& touches);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace swiftlet::sim
