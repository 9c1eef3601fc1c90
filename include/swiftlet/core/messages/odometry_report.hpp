// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Report of a guided vehicle: its odometry, and its progress on the received path.
struct OdometryReport {
  static constexpr const char* kTopic = "odometry";
  static constexpr int kVersion = 1;
  static constexpr const char* kDoc = "pose of the sender in its local frame, and visited waypoints";

  TimeNs t = 0;
  Pose T_local_body = Pose::Identity();
  Vector3 v_local_mps = Vector3::Zero();
  double yaw_rate_radps = 0.0;
  std::uint32_t path = 0;
  std::uint16_t num_visited = 0;

  static void visit(auto& m, auto& v) {
    v.time("t_s", m.t, "[s] time of validity, by the sender's clock");
    v.field("*", m.T_local_body, "[m, -] pose of the body in the sender's local frame");
    v.field("v*_mps", m.v_local_mps, "[m/s] velocity, in the axes of that frame");
    v.field("yaw_rate_radps", m.yaw_rate_radps, "[rad/s] rate of the heading");
    v.field("path", m.path, "[-] number of the newest received path; 0: none");
    v.field("num_visited", m.num_visited, "[-] visited waypoints of that path");
  }
};

}  // namespace swiftlet
