// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet {

/// Noise model of an IMU for filters; defaults: ADIS16448 as in RotorS and PX4.
struct ImuNoise {
  double gyro_noise_radps_sqrt_hz = 3.39e-4;
  double gyro_walk_radps2_sqrt_hz = 3.88e-5;
  double accel_noise_mps2_sqrt_hz = 4e-3;
  double accel_walk_mps3_sqrt_hz = 6e-3;
  double start_gyro_bias_sigma_radps = 0.0087;
  double start_accel_bias_sigma_mps2 = 0.196;

  void visit_noise(ConfigVisitor& v);
};

}  // namespace swiftlet
