// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/imu_noise.hpp"

namespace swiftlet {

void ImuNoise::visit_noise(ConfigVisitor& v) {
  const Range positive = Range::positive();
  const Range not_negative = Range::non_negative();
  v.field("gyro_noise_radps_sqrt_hz", gyro_noise_radps_sqrt_hz,
          "[rad/s/sqrt(Hz)] density of the gyroscope's white noise", positive);
  v.field("gyro_walk_radps2_sqrt_hz", gyro_walk_radps2_sqrt_hz,
          "[rad/s^2/sqrt(Hz)] random walk of the gyroscope's bias", not_negative);
  v.field("accel_noise_mps2_sqrt_hz", accel_noise_mps2_sqrt_hz,
          "[m/s^2/sqrt(Hz)] density of the accelerometer's white noise", positive);
  v.field("accel_walk_mps3_sqrt_hz", accel_walk_mps3_sqrt_hz,
          "[m/s^3/sqrt(Hz)] random walk of the accelerometer's bias", not_negative);
  v.field("start_gyro_bias_sigma_radps", start_gyro_bias_sigma_radps, "[rad/s] turn-on bias of the gyroscope",
          positive);
  v.field("start_accel_bias_sigma_mps2", start_accel_bias_sigma_mps2, "[m/s^2] turn-on bias of the accelerometer",
          positive);
}

}  // namespace swiftlet
