// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// A flying object followed over time [Vrba 2025, sec. III-F]. State: position, velocity, acceleration, world frame of
/// the agent's own estimate.
struct Track {
  std::uint32_t id = 0;
  TimeNs t = 0;
  Vector3 position_m = Vector3::Zero();
  Vector3 velocity_mps = Vector3::Zero();
  Vector3 acceleration_mps2 = Vector3::Zero();
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Identity();
  int num_detections = 0;  ///< detections associated so far
  bool corrected = false;  ///< a measurement was found in the newest cloud
};

}  // namespace swiftlet
