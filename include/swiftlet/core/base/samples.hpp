// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

/// Samples of a vehicle's sensors other than LiDARs. `t` is the time of validity, not of delivery. `kName` names the
/// table and the topic of a sample type in recordings; its `visit` is all that recordings need (fields.hpp).
namespace swiftlet {

/// Mean over the sampling interval that ends at t, as measured by a real IMU with its anti-aliasing filter.
struct ImuSample {
  static constexpr const char* kName = "imu";
  TimeNs t = 0;
  Vector3 omega_body_radps = Vector3::Zero();
  Vector3 specific_force_body_mps2 = Vector3::Zero();  ///< acceleration minus gravity: (0, 0, +9.81) at rest

  static void visit(auto& s, auto& v) {
    v.time("t_s", s.t, "[s] end of the averaging interval");
    v.field("omega_*_radps", s.omega_body_radps, "[rad/s] body rate, in body axes");
    v.field("f_*_mps2", s.specific_force_body_mps2, "[m/s^2] specific force, in body axes; (0, 0, 9.81) at rest");
  }
};

/// Visual-inertial (or any other) odometry: pose and velocity in a local frame of arbitrary origin and heading, which
/// drifts. Its z axis is up.
struct OdometrySample {
  static constexpr const char* kName = "odometry";
  TimeNs t = 0;
  Pose T_local_body = Pose::Identity();
  Vector3 v_local_body_mps = Vector3::Zero();

  static void visit(auto& s, auto& v) {
    v.time("t_s", s.t, "[s] time of validity");
    v.field("*", s.T_local_body, "[m, -] pose of the body in the local frame, which drifts");
    v.field("v*_mps", s.v_local_body_mps, "[m/s] velocity, in local axes");
  }
};

/// Position in the east-north-up frame of the world.
struct GnssSample {
  static constexpr const char* kName = "gnss";
  TimeNs t = 0;
  Vector3 p_world_m = Vector3::Zero();
  Vector3 v_world_mps = Vector3::Zero();
  Vector3 sigma_p_m = Vector3::Ones();
  Vector3 sigma_v_mps = Vector3::Ones();

  static void visit(auto& s, auto& v) {
    v.time("t_s", s.t, "[s] time of validity");
    v.field("*_m", s.p_world_m, "[m] position in the world");
    v.field("v*_mps", s.v_world_mps, "[m/s] velocity, in world axes");
    v.field("sigma_*_m", s.sigma_p_m, "[m] standard deviation of the position");
    v.field("sigma_v*_mps", s.sigma_v_mps, "[m/s] standard deviation of the velocity");
  }
};

/// Height above the surface below, along the world's vertical.
struct AltimeterSample {
  static constexpr const char* kName = "altimeter";
  TimeNs t = 0;
  double height_m = 0.0;
  double sigma_m = 0.0;

  static void visit(auto& s, auto& v) {
    v.time("t_s", s.t, "[s] time of validity");
    v.field("height_m", s.height_m, "[m] height above the surface below the vehicle");
    v.field("sigma_m", s.sigma_m, "[m] standard deviation");
  }
};

/// Heading of the body's x axis, counter-clockwise from east.
struct CompassSample {
  static constexpr const char* kName = "compass";
  TimeNs t = 0;
  double yaw_rad = 0.0;
  double sigma_rad = 0.0;

  static void visit(auto& s, auto& v) {
    v.time("t_s", s.t, "[s] time of validity");
    v.field("yaw_rad", s.yaw_rad, "[rad] heading, counter-clockwise from east");
    v.field("sigma_rad", s.sigma_rad, "[rad] standard deviation");
  }
};

/// Pose in the world from an external source: motion capture, RTK, or the simulator's truth.
struct PoseSample {
  static constexpr const char* kName = "pose";
  TimeNs t = 0;
  Pose T_world_body = Pose::Identity();
  Vector3 v_world_mps = Vector3::Zero();
  Vector3 omega_body_radps = Vector3::Zero();

  static void visit(auto& s, auto& v) {
    v.time("t_s", s.t, "[s] time of validity");
    v.field("*", s.T_world_body, "[m, -] pose of the body in the world");
    v.field("v*_mps", s.v_world_mps, "[m/s] velocity, in world axes");
    v.field("omega_*_radps", s.omega_body_radps, "[rad/s] body rate, in body axes");
  }
};

/// Position of another vehicle measured by a mutual-localization sensor (UVDAR and the like).
struct NeighborSample {
  static constexpr const char* kName = "neighbors";
  TimeNs t = 0;
  VehicleId id = kNoVehicle;
  Vector3 p_body_m = Vector3::Zero();  ///< position of the neighbor in the body frame of the observer
  Matrix3 covariance_body = Matrix3::Identity();

  static void visit(auto& s, auto& v) {
    v.time("t_s", s.t, "[s] time of validity");
    v.vehicle("neighbor", s.id, "[-] observed vehicle; empty: not identified");
    v.field("*_body_m", s.p_body_m, "[m] position of the neighbor in the body frame of the observer");
    v.covariance("cov_*_m2", s.covariance_body, "[m^2] covariance of the position");
  }
};

}  // namespace swiftlet
