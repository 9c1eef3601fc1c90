// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet::testing {

/// A pose whose position and rotation vector are normally distributed with these standard deviations per axis.
inline Pose random_pose(std::mt19937& random, double spread_m = 5.0, double spread_rad = 1.0) {
  std::normal_distribution<double> normal;
  Vector6 x;
  for (int i = 0; i < 6; ++i) x(i) = normal(random);
  return make_pose(spread_m * x.head<3>(), rotation_by(spread_rad * x.tail<3>()));
}

/// A symmetric matrix without an eigenvalue below one.
inline Matrix6 random_information(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Matrix6 A;
  for (int i = 0; i < 36; ++i) A(i) = normal(random);
  return A * A.transpose() + Matrix6::Identity();
}

}  // namespace swiftlet::testing
