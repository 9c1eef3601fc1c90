// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/sim/sensors/mount_error_config.hpp"
#include "swiftlet/sim/sensors/outage_config.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"
#include "swiftlet/sim/sensors/vibration_config.hpp"

namespace swiftlet::sim {

/// Inertial measurement unit. Noise model as in RotorS and Kalibr: white noise by density, bias as Gauss-Markov process
/// plus a turn-on bias drawn once. Defaults: ADIS16448 as in RotorS/PX4.
struct ImuConfig : SensorConfigOf<ImuConfig> {
  std::string model;
  double rate_hz = 250.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_rpy_deg = Eigen::Vector3d::Zero();
  double gyro_noise_density_radps_psqrthz = 3.39e-4;
  double gyro_bias_walk_radps2_psqrthz = 3.88e-5;
  double gyro_bias_time_s = 1000.0;
  double gyro_turn_on_bias_radps = 0.0087;
  double gyro_max_radps = 34.9;
  double accel_noise_density_mps2_psqrthz = 4e-3;
  double accel_bias_walk_mps3_psqrthz = 6e-3;
  double accel_bias_time_s = 300.0;
  double accel_turn_on_bias_mps2 = 0.196;
  double accel_max_mps2 = 176.6;
  MountErrorConfig mount_error;
  VibrationConfig vibration;
  double dropout_probability = 0.0;  ///< samples that are not delivered
  std::vector<OutageConfig> outages;

  void visit(ConfigVisitor& v) override;
};

/// A sample holds the means over its interval h, computed from the true states at both ends:
///   omega = log(R_0^T R_1) / h,   f = R_mid^T ((v_1 - v_0) / h - g),   R_mid = R_0 exp(h omega / 2).
/// Integrating noise-free samples (R, then v with R_mid) therefore reproduces attitude and velocity exactly, and the
/// position to second order. v is the velocity of the mounting point. Noise and saturation act in the sensor's axes.
/// The sample is given in body axes, as by a flight controller with calibrated mounting; `mount_error` remains in it.
/// Vibration is added before noise and saturation. Lost samples leave their interval without a measurement.
std::unique_ptr<Sensor> make_imu_sensor(const ModuleConfig& config, SensorSetup setup);

}  // namespace swiftlet::sim
