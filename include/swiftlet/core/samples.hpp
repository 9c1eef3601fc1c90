// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/frames.hpp"

/// What a vehicle's sensors other than LiDARs say. `t` is the time of validity, not of delivery.
namespace swiftlet {

/// Mean over the sampling interval that ends at t, as a real IMU with its anti-aliasing filter gives.
struct ImuSample {
  TimeNs t = 0;
  Vector3 omega_body_radps = Vector3::Zero();
  Vector3 specific_force_body_mps2 = Vector3::Zero();  ///< acceleration minus gravity: (0, 0, +9.81) at rest
};

/// Visual-inertial (or any other) odometry: pose and velocity in a local frame of arbitrary origin and heading, which
/// drifts. Its z axis is up.
struct OdometrySample {
  TimeNs t = 0;
  Pose T_local_body = Pose::Identity();
  Vector3 v_local_body_mps = Vector3::Zero();
};

/// Position in the east-north-up frame of the world.
struct GnssSample {
  TimeNs t = 0;
  Vector3 p_world_m = Vector3::Zero();
  Vector3 v_world_mps = Vector3::Zero();
  Vector3 sigma_p_m = Vector3::Ones();
  Vector3 sigma_v_mps = Vector3::Ones();
};

/// Height above the surface below, along the world's vertical.
struct AltimeterSample {
  TimeNs t = 0;
  double height_m = 0.0;
  double sigma_m = 0.0;
};

/// Heading of the body's x axis, counter-clockwise from east.
struct CompassSample {
  TimeNs t = 0;
  double yaw_rad = 0.0;
  double sigma_rad = 0.0;
};

/// Pose in the world from outside: motion capture, RTK, or the simulator's truth (the named bypass).
struct PoseSample {
  TimeNs t = 0;
  Pose T_world_body = Pose::Identity();
  Vector3 v_world_mps = Vector3::Zero();
  Vector3 omega_body_radps = Vector3::Zero();
};

/// Another vehicle as a mutual-localization sensor sees it (UVDAR and the like).
struct NeighborSample {
  TimeNs t = 0;
  VehicleId id = kNoVehicle;
  Vector3 p_body_m = Vector3::Zero();  ///< position of the other in the body frame of the observer
  Matrix3 covariance_body = Matrix3::Identity();
};

}  // namespace swiftlet
