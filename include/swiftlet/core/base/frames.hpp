// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/time.hpp"

/// Frames (docs/conventions.md):
/// - world: east, north, up;
/// - body: forward, left, up, with the origin in the center of mass;
/// - lidar: as the sensor's driver defines it;
/// - local: smooth and drifting, from a vehicle's start; control, clouds and maps of the vehicle use it.
///
/// A transform names both frames, destination first: point_world = T_world_body * point_body.
namespace swiftlet {

using Pose = Eigen::Isometry3d;
using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Index of a vehicle in the scenario, from 0. Also its address on the radio.
using VehicleId = std::int32_t;
/// No vehicle; as a receiver: all vehicles.
inline constexpr VehicleId kNoVehicle = -1;

struct StampedPose {
  TimeNs t = 0;
  Pose T_world_body = Pose::Identity();

  static void visit(auto& s, auto& v) {
    v.time("t_s", s.t, "[s] time of validity");
    v.field("*", s.T_world_body, "[m, -] pose of the body in the world");
  }
};

/// Any frame, the same for all arguments.
inline Pose make_pose(const Vector3& position, const Eigen::Quaterniond& rotation) {
  Pose pose = Pose::Identity();
  pose.linear() = rotation.toRotationMatrix();
  pose.translation() = position;
  return pose;
}

/// Heading of the body's x axis in the x-y plane of the destination frame [rad], (-pi, pi].
inline double yaw_of(const Matrix3& R) { return elementary::atan2(R(1, 0), R(0, 0)); }

}  // namespace swiftlet
