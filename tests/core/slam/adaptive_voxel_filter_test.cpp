// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/adaptive_voxel_filter.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <set>
#include <vector>

namespace swiftlet {
namespace {

std::vector<Eigen::Vector3f> cloud_of(int num, float size_m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-size_m, size_m);
  std::vector<Eigen::Vector3f> points_m(num);
  for (Eigen::Vector3f& p : points_m) p = {uniform(random), uniform(random), 0.1F * uniform(random)};
  return points_m;
}

/// The first point of each cube, by a plain set of cubes.
std::vector<Eigen::Vector3f> thinned(const std::vector<Eigen::Vector3f>& points_m, double edge_m, double range_m) {
  std::vector<Eigen::Vector3f> kept_m;
  std::set<std::array<int, 3>> cubes;
  for (const Eigen::Vector3f& p : points_m) {
    if (p.norm() > range_m) continue;
    std::array<int, 3> cube;
    for (int axis = 0; axis < 3; ++axis)
      cube[axis] = static_cast<int>(std::floor(p(axis) * (1.0F / static_cast<float>(edge_m))));
    if (cubes.insert(cube).second) kept_m.push_back(p);
  }
  return kept_m;
}

// Brute force: the edge that is found leaves enough, and one that is a tenth wider does not.
TEST(AdaptiveVoxelFilter, FindsLargestVoxelsKeepingEnoughPoints) {
  AdaptiveVoxelFilter filter;
  for (const int points_min : {20, 150, 400, 1500, 3000}) {
    for (const unsigned seed : {1U, 2U, 3U}) {
      const std::vector<Eigen::Vector3f> points_m = cloud_of(8000, 20.0F, seed);
      const AdaptiveVoxelConfig config{4.0, points_min, 15.0};
      std::vector<Eigen::Vector3f> kept_m;
      const double edge_m = filter.thin(points_m, config, kept_m);
      ASSERT_GT(edge_m, 0.0);
      EXPECT_EQ(kept_m, thinned(points_m, edge_m, 15.0));
      EXPECT_GE(static_cast<int>(kept_m.size()), points_min);
      if (edge_m < config.edge_max_m) {
        EXPECT_LT(static_cast<int>(thinned(points_m, 1.1 * edge_m, 15.0).size()), 1.03 * points_min) << edge_m;
      }
    }
  }
}

TEST(AdaptiveVoxelFilter, LimitsThinningToTheMaximumSize) {
  AdaptiveVoxelFilter filter;
  std::vector<Eigen::Vector3f> kept_m;
  EXPECT_EQ(filter.thin(cloud_of(8000, 20.0F, 4), {0.5, 10, 15.0}, kept_m), 0.5);
  EXPECT_GT(kept_m.size(), 1000U);
}

TEST(AdaptiveVoxelFilter, KeepsSparseCloudsExceptFarPoints) {
  AdaptiveVoxelFilter filter;
  std::vector<Eigen::Vector3f> kept_m;
  const std::vector<Eigen::Vector3f> points_m{{1, 0, 0}, {1.001F, 0, 0}, {14.99F, 0, 0}, {15.01F, 0, 0}};
  EXPECT_EQ(filter.thin(points_m, {2.0, 3, 15.0}, kept_m), 0.0);
  EXPECT_EQ(kept_m, (std::vector<Eigen::Vector3f>{points_m[0], points_m[1], points_m[2]}));
}

TEST(AdaptiveVoxelFilter, GivesUpOnCoincidentPoints) {
  AdaptiveVoxelFilter filter;
  std::vector<Eigen::Vector3f> kept_m, points_m(100, Eigen::Vector3f(1, 2, 3));
  const double edge_m = filter.thin(points_m, {2.0, 50, 15.0}, kept_m);
  EXPECT_LE(edge_m, 0.02);
  EXPECT_EQ(kept_m.size(), 1U);
}

}  // namespace
}  // namespace swiftlet
