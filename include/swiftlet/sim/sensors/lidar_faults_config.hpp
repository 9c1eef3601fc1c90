// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// A part of the own rig that no self-mask covers, such as an antenna or a cable: a box with the body's axes.
struct RigPartConfig {
  Eigen::Vector3d center_m = {0.2, 0.0, 0.2};  ///< body frame
  Eigen::Vector3d size_m = {0.02, 0.02, 0.1};
  double reflectivity = 0.1;

  void visit(ConfigVisitor& v);
};

/// Faults of a real LiDAR that its range noise and its receiver's sensitivity do not explain. The defaults have none.
struct LidarFaultsConfig {
  double dropout_probability = 0.0;  ///< share of shots without return, regardless of the surface
  double tail_probability = 0.0;     ///< returns whose noise is tail_factor times larger
  double tail_factor = 10.0;
  double range_step_m = 0.0;
  /// s of a log-logistic factor c (u / (1 - u))^s of the reflectivity with mean 1 from shot to shot, u uniform in (0,
  /// 1), c = sin(pi s) / (pi s). Larger values give more dark and more bright returns; the median is c.
  double reflectivity_spread = 0.0;
  double near_per_sweep = 0.0;  ///< mean number of returns of the window, nearer than LidarConfig::range_min_m or not
  Eigen::Vector2d near_range_m = {0.1, 0.12};  ///< uniform between these
  std::vector<RigPartConfig> rig;              ///< seen where nothing nearer is, from range_min_m on

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
