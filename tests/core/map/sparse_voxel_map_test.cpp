// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/sparse_voxel_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/math/random.hpp"

namespace swiftlet {
namespace {

using Ray = SparseVoxelMap::Ray;

constexpr TimeNs kSweep = kNsPerSecond / 10;

/// A wall at x = 3 m seen from the origin.
std::vector<Ray> wall() {
  std::vector<Ray> rays;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) rays.push_back({{0, 0, 0}, {3.05F, 0.05F * i + 0.01F, 0.05F * j + 0.01F}, true});
  }
  return rays;
}

TEST(SparseVoxelMap, WallIsWhereItWasSeenAndNowhereElse) {
  SparseVoxelMap map({});
  for (int i = 1; i <= 5; ++i) map.insert(wall(), i * kSweep);
  std::vector<Vector3> voxels;
  map.collect(Vector3::Zero(), 10.0, 5 * kSweep, 0, voxels);
  ASSERT_FALSE(voxels.empty());
  for (const Vector3& voxel : voxels) {
    EXPECT_NEAR(voxel.x(), 3.1, 1e-9);
    EXPECT_LE(std::abs(voxel.y()), 1.11);
  }
  EXPECT_TRUE(map.is_occupied({3.05, 0.0, 0.0}, 5 * kSweep));
  EXPECT_FALSE(map.is_occupied({2.5, 0.0, 0.0}, 5 * kSweep));
}

TEST(SparseVoxelMap, CollectsExactlyTheVoxelsThatReachIntoTheBall) {
  SparseVoxelMapConfig config;
  config.edge_m = 0.25;
  SparseVoxelMap map(config);
  std::vector<Ray> rays;
  const Random random(7, "test");
  for (std::uint32_t i = 0; i < 3000; ++i) {
    const auto n = random.normal3(0, i);
    rays.push_back(
        {{0, 0, 0},
         Eigen::Vector3f(static_cast<float>(3 * n[0]), static_cast<float>(3 * n[1]), static_cast<float>(n[2])),
         true});
  }
  map.insert(rays, kSweep);
  const Vector3 center(0.4, -1.2, 0.3);
  const double radius = 2.3;
  std::vector<Vector3> voxels;
  map.collect(center, radius, kSweep, 0, voxels);
  std::vector<std::array<int, 3>> expected;
  for (const Ray& ray : rays) {
    const Eigen::Array3d cell = (ray.end_m.cast<double>().array() / 0.25).floor();
    const Vector3 low = cell.matrix() * 0.25, high = low.array() + 0.25;
    if ((center - center.cwiseMax(low).cwiseMin(high)).norm() > radius) continue;
    expected.push_back({static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())});
  }
  std::sort(expected.begin(), expected.end());
  expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
  EXPECT_EQ(voxels.size(), expected.size());
  EXPECT_GT(voxels.size(), 50U);
}

TEST(SparseVoxelMap, GhostIsClearedByRaysThatPassAndKeptByTheConservativeSetting) {
  SparseVoxelMapConfig conservative;
  conservative.miss_log_odds = 0.0;
  SparseVoxelMap forgets({}), keeps(conservative);
  const std::vector<Ray> leaf = {{{0, 0, 0}, {1.5F, 0.05F, 0.05F}, true}};
  for (int i = 1; i <= 3; ++i) {
    forgets.insert(leaf, i * kSweep);
    keeps.insert(leaf, i * kSweep);
  }
  const Vector3 ghost(1.5, 0.05, 0.05);
  ASSERT_TRUE(forgets.is_occupied(ghost, 3 * kSweep));
  for (int i = 4; i <= 13; ++i) {  // one second of looking at the wall behind
    forgets.insert(wall(), i * kSweep);
    keeps.insert(wall(), i * kSweep);
  }
  EXPECT_FALSE(forgets.is_occupied(ghost, 13 * kSweep));
  EXPECT_TRUE(keeps.is_occupied(ghost, 13 * kSweep));
  EXPECT_TRUE(forgets.is_occupied({3.05, 0.0, 0.0}, 13 * kSweep));
}

TEST(SparseVoxelMap, BeamsWithoutReturnClearAndMemoryFades) {
  SparseVoxelMapConfig fading;
  fading.memory_s = 2.0;
  SparseVoxelMap map({}), fades(fading);
  const std::vector<Ray> leaf = {{{0, 0, 0}, {1.5F, 0.05F, 0.05F}, true}};
  map.insert(leaf, kSweep);
  fades.insert(leaf, kSweep);
  const std::vector<Ray> sky = {{{0, 0, 0}, {8.0F, 0.2667F, 0.2667F}, false}};
  for (int i = 2; i <= 10; ++i) map.insert(sky, i * kSweep);
  const Vector3 ghost(1.5, 0.05, 0.05);
  EXPECT_FALSE(map.is_occupied(ghost, 10 * kSweep));
  EXPECT_TRUE(fades.is_occupied(ghost, 10 * kSweep));
  EXPECT_FALSE(fades.is_occupied(ghost, 30 * kSweep));
}

TEST(SparseVoxelMap, SurfaceSeenAtAGrazingAngleDoesNotEatItself) {
  SparseVoxelMap map({});
  std::vector<Ray> ground;
  for (int i = 0; i < 400; ++i) ground.push_back({{0, 0, 1.0F}, {0.5F + 0.02F * i, 0.03F, 0.02F}, true});
  for (int i = 1; i <= 30; ++i) map.insert(ground, i * kSweep);
  for (int i = 0; i < 37; ++i) EXPECT_TRUE(map.is_occupied({0.6 + 0.2 * i, 0.03, 0.02}, 30 * kSweep)) << i;
}

TEST(SparseVoxelMap, ForgetsWhatIsFarAwayAndUsesItsMemoryAgain) {
  SparseVoxelMapConfig config;
  config.keep_radius_m = 5.0;
  SparseVoxelMap map(config);
  for (int i = 1; i <= 200; ++i) {
    const auto x = static_cast<float>(0.5 * i);
    map.insert(std::vector<Ray>{{{x, 0, 0}, {x + 2.0F, 0.1F, 0.1F}, true}}, i * kSweep);
    map.keep_around({x, 0, 0});
  }
  EXPECT_LE(map.num_blocks(), 10U);
  EXPECT_TRUE(map.is_occupied({102.0, 0.1, 0.1}, 200 * kSweep));
  EXPECT_FALSE(map.is_occupied({20.0, 0.1, 0.1}, 200 * kSweep));
}

}  // namespace
}  // namespace swiftlet
