// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet {

struct RelativeFilterConfig {
  /// [m/s^2/sqrt(Hz)] white acceleration of the other vehicle between its samples
  double acceleration_mps2_psqrthz = 0.5;
  double odometry_sigma_m = 0.015;  ///< [m] white noise of the position of the other vehicle's odometry, per axis
  double odometry_velocity_sigma_mps = 0.06;  ///< [m/s] white noise of the velocity of that odometry
  double odometry_yaw_sigma_deg = 0.5;        ///< [deg] white noise of the heading of that odometry
  double yaw_rate_sigma_degps = 10.0;  ///< [deg/s] growth of the heading's standard deviation since the newest sample
  double bias_sigma_m = 0.02;
  /// [-] residual in standard deviations beyond which a sighting is rejected; larger values accept false sightings
  double gate_sigma = 4.0;
  double drift_factor_max = 10.0;

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet
