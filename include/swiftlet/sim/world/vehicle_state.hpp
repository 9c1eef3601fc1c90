// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet::sim {

/// True state of one vehicle at one instant. Plain, trivially copyable apart from Eigen.
struct VehicleState {
  TimeNs t = 0;
  Vector3 p_world_m = Vector3::Zero();  ///< center of mass = origin of the body frame
  Eigen::Quaterniond q_world_body = Eigen::Quaterniond::Identity();
  Vector3 v_world_mps = Vector3::Zero();
  Vector3 omega_body_radps = Vector3::Zero();
  std::array<double, kMaxRotors> rotor_speed_radps{};  ///< >= 0
  /// Rotation since the start, signed by the sense of rotation, not wrapped
  std::array<double, kMaxRotors> rotor_angle_rad{};
  bool crashed = false;

  static void visit(auto& s, auto& v) {
    v.time("t_s", s.t, "[s] time of validity");
    v.field("*_m", s.p_world_m, "[m] true position in the world");
    v.field("*", s.q_world_body, "[-] true rotation from body to world axes");
    v.field("v*_mps", s.v_world_mps, "[m/s] true velocity, in world axes");
    v.field("omega_*_radps", s.omega_body_radps, "[rad/s] true body rate, in body axes");
    v.array("rotor*_radps", s.rotor_speed_radps, "[rad/s] true rotor speed");
    v.array("rotor*_rad", s.rotor_angle_rad, "[rad] rotation since the start");
    v.field("crashed", s.crashed, "[-] 1: crashed");
  }

  Pose T_world_body() const { return make_pose(p_world_m, q_world_body); }
};

/// State between two instants: cubic Hermite in position, slerp in attitude, linear in the rest. t is clamped to [a.t,
/// b.t].
VehicleState interpolate(const VehicleState& a, const VehicleState& b, TimeNs t);

/// Recent states of all vehicles at physics rate, so that a sensor can sample any instant of its sweep.
/// Ring buffer; at() never allocates.
class StateHistory {
 public:
  StateHistory() = default;
  StateHistory(int num_vehicles, int capacity);

  void push(VehicleId vehicle, const VehicleState& state);  ///< in order of time
  const VehicleState& latest(VehicleId vehicle) const;
  /// Interpolated state; clamped to the oldest and newest stored ones.
  VehicleState at(VehicleId vehicle, TimeNs t) const;
  int num_vehicles() const { return num_vehicles_; }

 private:
  const VehicleState& nth_newest(VehicleId vehicle, int n) const;
  int num_vehicles_ = 0;
  int capacity_ = 0;
  std::vector<VehicleState> ring_;  // (num_vehicles x capacity)
  std::vector<int> newest_;         // (num_vehicles), index in its row
  std::vector<int> count_;          // (num_vehicles)
};

}  // namespace swiftlet::sim
