// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// Part of the observer's own structure that the LiDAR's self-mask does not remove, such as an antenna or a cable:
/// modeled as a box aligned with the body axes.
struct RigPartConfig {
  Eigen::Vector3d center_m = {0.2, 0.0, 0.2};  ///< [m] center of the box in the body frame
  Eigen::Vector3d size_m = {0.02, 0.02, 0.1};  ///< [m] edges of the box
  double reflectivity = 0.1;                   ///< [-] Lambertian reflectivity

  void visit(ConfigVisitor& v);
};

/// Measurement faults of real LiDARs beyond range noise and limited receiver sensitivity: lost shots, outliers, coarse
/// ranges, varying reflectivity, returns of the sensor's window and of the vehicle itself. The defaults disable all.
struct LidarFaultsConfig {
  double dropout_probability = 0.0;  ///< [-] share of shots without return, regardless of the surface
  double tail_probability = 0.0;     ///< [-] share of outliers, returns with tail_factor times the range noise
  double tail_factor = 10.0;         ///< [-] factor of the range noise of outliers
  double range_step_m = 0.0;         ///< [m] resolution of the reported range; 0: continuous
  /// [-] Spread s of the factor by which the reflectivity varies from shot to shot: c (u / (1 - u))^s with u uniform in
  /// (0, 1), a log-logistic distribution with mean 1 and median c = sin(pi s) / (pi s). Larger values give more dark
  /// and more bright returns.
  double reflectivity_spread = 0.0;
  /// [-] Mean number per sweep of false returns from the LiDAR's protective window. LidarConfig::range_min_m does not
  /// suppress them.
  double near_per_sweep = 0.0;
  /// [m] Smallest and largest range of returns from the window; their ranges are uniformly distributed.
  Eigen::Vector2d near_range_m = {0.1, 0.12};
  /// Parts of the own structure. A beam returns from the first part it meets at LidarConfig::range_min_m or beyond,
  /// unless another surface is nearer.
  std::vector<RigPartConfig> rig;

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
