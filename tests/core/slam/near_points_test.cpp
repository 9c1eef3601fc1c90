// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/near_points.hpp"

#include <gtest/gtest.h>

#include <random>

namespace swiftlet {
namespace {

TEST(NearPoints, ContainCloseButNoDistantPoints) {
  constexpr double kVoxel_m = 0.2;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-3.0, 3.0);
  const auto point = [&] { return Vector3(uniform(random), uniform(random), uniform(random)); };
  std::vector<Eigen::Vector3f> others_m;
  for (int i = 0; i < 60; ++i) others_m.push_back(point().cast<float>());
  const NearPoints near(kVoxel_m, others_m);
  int within = 0, beyond = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3 p_m = point();
    double least_m = 1e9;  // along the axis of the largest difference
    for (const Eigen::Vector3f& q : others_m) {
      least_m = std::min(least_m, (q.cast<double>() - p_m).cwiseAbs().maxCoeff());
    }
    if (least_m < kVoxel_m) {
      ++within;
      EXPECT_TRUE(near.contain(p_m));
    }
    if (least_m > 3.0 * kVoxel_m) {
      ++beyond;
      EXPECT_FALSE(near.contain(p_m));
    }
  }
  EXPECT_GT(within, 100);
  EXPECT_GT(beyond, 100);
}

}  // namespace
}  // namespace swiftlet
