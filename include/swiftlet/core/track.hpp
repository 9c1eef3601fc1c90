// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// A flying object followed over time [Vrba 2025, sec. III-F]: its position, velocity and acceleration. Local frame
/// between stages, world in Action.
struct Track {
  static constexpr const char* kName = "tracks";
  std::uint32_t id = 0;
  TimeNs t = 0;
  Vector3 position_m = Vector3::Zero();
  Vector3 velocity_mps = Vector3::Zero();
  Vector3 acceleration_mps2 = Vector3::Zero();
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Identity();
  int num_detections = 0;  ///< detections associated so far
  bool corrected = false;  ///< a measurement was found in the newest cloud

  static void visit(auto& t, auto& v) {
    v.time("t_s", t.t, "[s] when its target was seen in the newest cloud");
    v.field("id", t.id, "[-] its identity");
    v.field("*_m", t.position_m, "[m] in the world of the estimate");
    v.field("v*_mps", t.velocity_mps, "[m/s] velocity, in the same axes");
    v.field("a*_mps2", t.acceleration_mps2, "[m/s^2] acceleration, in the same axes");
    v.covariance("cov_*_m2", t.covariance, "[m^2] covariance of the position");
    v.field("num_detections", t.num_detections, "[-] detections associated so far");
    v.field("corrected", t.corrected, "[-] 1: a measurement was found in the newest cloud");
  }
};

}  // namespace swiftlet
