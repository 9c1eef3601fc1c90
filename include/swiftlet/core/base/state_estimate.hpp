// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Estimated state of the vehicle, in two frames as in REP-105. The local frame is smooth: control, references, clouds
/// and maps use it and never see a jump. Its pose in the world is the correction, which may jump when the estimator
/// improves its estimate.
struct StateEstimate {
  TimeNs t = 0;
  bool valid = false;
  Pose T_local_body = Pose::Identity();
  Vector3 v_local_mps = Vector3::Zero();
  Vector3 omega_body_radps = Vector3::Zero();
  Matrix6 covariance = Matrix6::Zero();   ///< position in the local frame [m], rotation vector in body axes [rad]
  Pose T_world_local = Pose::Identity();  ///< correction as estimated by the vehicle; may change slowly
  std::uint32_t correction_revision = 0;  ///< number of changes of the correction; 0: it is the identity

  /// Sets the correction; an equal one changes nothing.
  void correct(const Pose& T_world_local_now) {
    if (T_world_local_now.matrix() == T_world_local.matrix()) return;
    T_world_local = T_world_local_now;
    ++correction_revision;
  }
  Pose T_world_body() const { return correction_revision == 0 ? T_local_body : T_world_local * T_local_body; }
  Vector3 v_world_mps() const {
    return correction_revision == 0 ? v_local_mps : Vector3(T_world_local.linear() * v_local_mps);
  }

  static void visit(auto& e, auto& v) {
    v.valid("valid", e.valid, "[-] 1: the estimate is valid");
    v.time("t_s", e.t, "[s] time of validity");
    v.field("local_*", e.T_local_body, "[m, -] pose of the body in the local frame");
    v.field("local_v*_mps", e.v_local_mps, "[m/s] velocity, in local axes");
    v.field("omega_*_radps", e.omega_body_radps, "[rad/s] body rate, in body axes");
    v.covariance("cov_*_m2", e.covariance, "[m^2] covariance of the position, in local axes");
    v.field("correction_*", e.T_world_local, "[m, -] pose of the local frame in the world");
    v.field("correction_revision", e.correction_revision, "[-] number of changes of the correction");
  }
};

/// Estimate in world axes, for recordings.
struct WorldEstimate {
  TimeNs t = 0;
  bool valid = false;
  Pose T_world_body = Pose::Identity();
  Vector3 v_world_mps = Vector3::Zero();
  Vector3 omega_body_radps = Vector3::Zero();
  Matrix6 covariance = Matrix6::Zero();  ///< position in world axes [m], rotation vector in body axes [rad]

  static void visit(auto& e, auto& v) {
    v.valid("valid", e.valid, "[-] 1: the estimate is valid");
    v.time("t_s", e.t, "[s] time of validity");
    v.field("*", e.T_world_body, "[m, -] pose of the body in the vehicle's estimated world frame");
    v.field("v*_mps", e.v_world_mps, "[m/s] velocity, in the axes of that frame");
    v.field("omega_*_radps", e.omega_body_radps, "[rad/s] body rate, in body axes");
    v.covariance("cov_*_m2", e.covariance, "[m^2] covariance of the position");
  }
};

inline WorldEstimate in_world(const StateEstimate& e) {
  WorldEstimate out{e.t, e.valid, e.T_world_body(), e.v_world_mps(), e.omega_body_radps, e.covariance};
  if (e.correction_revision == 0) return out;
  Matrix6 J = Matrix6::Identity();
  J.topLeftCorner<3, 3>() = e.T_world_local.linear();
  out.covariance = J * e.covariance * J.transpose();
  return out;
}

}  // namespace swiftlet
