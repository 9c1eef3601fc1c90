// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "swiftlet/core/map/sparse_voxel_map.hpp"
#include "swiftlet/core/map/voxel_map.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

/// Length of a segment within a cube.
double length_in(const Vector3& from, const Vector3& to, const Vector3& center, double edge) {
  double enter = 0.0, leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double length = to[axis] - from[axis];
    double a = (center[axis] - 0.5 * edge - from[axis]) / length, b = (center[axis] + 0.5 * edge - from[axis]) / length;
    if (a > b) std::swap(a, b);
    enter = std::max(enter, a);
    leave = std::min(leave, b);
  }
  return std::max(0.0, leave - enter) * (to - from).norm();
}

// Long rays cross blocks without stored voxels in one step, in any direction.
TEST(SparseVoxelMap, RayLowersExactlyVoxelsItCrosses) {
  const Random random(8, "passes");
  int passed = 0, spared = 0;
  for (std::uint32_t k = 0; k < 60; ++k) {
    SparseVoxelMapConfig config;
    config.clear_range_m = 20.0;
    SparseVoxelMap map(config);
    const auto point = [&](std::uint32_t channel, double half_m) {
      return Vector3(random.uniform(-half_m, half_m, k, 3 * channel),
                     random.uniform(-half_m, half_m, k, 3 * channel + 1),
                     random.uniform(-half_m, half_m, k, 3 * channel + 2));
    };
    const Vector3 from = point(0, 6.0), to = point(1, 6.0);
    // Some voxels on the ray and beside it are known.
    std::vector<SparseVoxelMap::Ray> hits;
    for (std::uint32_t i = 0; i < 12; ++i) {
      const Vector3 at = from + random.uniform(k, 100 + i) * (to - from) + point(2 + i, 0.15);
      hits.push_back({(at + Vector3(0.0, 0.0, 0.01)).cast<float>(), at.cast<float>(), true});
    }
    map.insert(hits, 1);
    const auto values = [&] {
      MapVoxels copy;
      map.append_voxels(copy);
      std::map<std::tuple<float, float, float>, float> by_place;
      for (std::size_t i = 0; i < copy.size(); ++i) {
        const Eigen::Vector3f& c = copy.centers_local_m[i];
        by_place[{c.x(), c.y(), c.z()}] = copy.value[i];
      }
      return by_place;
    };
    const auto before = values();
    map.insert(std::vector<SparseVoxelMap::Ray>{{from.cast<float>(), to.cast<float>(), false}}, 2);
    for (const auto& [place, value] : values()) {
      const auto [x, y, z] = place;
      const double within_m = length_in(from, to, Vector3(x, y, z), config.edge_m);
      if (within_m > 0.0 && within_m < 0.005) continue;  // a corner, within rounding
      const double lost = before.at(place) - value;
      ASSERT_NEAR(lost, within_m > 0.0 ? config.miss_log_odds : 0.0, 1e-5) << k << ": " << within_m;
      ++(within_m > 0.0 ? passed : spared);
    }
  }
  EXPECT_GT(passed, 150);
  EXPECT_GT(spared, 150);
}

VoxelMap wide_map() {
  VoxelMapConfig config;
  config.extent = VoxelMapConfig::Extent::kBounded;
  config.size_m = {40.0, 2.0, 2.0};  // 160 voxels in a row: several words of bits
  return VoxelMap(config);
}

TEST(VoxelMap, CountsAndClearsRowVoxelsIndividually) {
  VoxelMap map = wide_map();
  const VoxelGrid& grid = map.grid();
  const int n = grid.size.x();
  for (int x = 0; x < n; ++x) {
    const Cell cell = grid.min_cell + Cell(x, 3, 2);
    map.set(grid.index(cell), -1.0F);
    ASSERT_EQ(map.num_occupied(), 1) << x;
    std::vector<Vector3> centers_m;
    map.append_centers(VoxelState::kTentative, centers_m);
    ASSERT_EQ(centers_m.size(), 1U) << x;
    ASSERT_EQ(centers_m[0], grid.center_m(cell)) << x;
    // Any other part of the row may move to free.
    const std::vector<float> others(static_cast<std::size_t>(n - x - 1), 50.0F);
    if (!others.empty()) map.move_to_free(cell + Cell(1, 0, 0), others);
    ASSERT_EQ(map.num_occupied(), 1) << x;
    map.move_to_free(cell, std::vector<float>{50.0F});
    ASSERT_EQ(map.num_occupied(), 0) << x;
  }
}

TEST(VoxelMap, IncludesTheBoundaryOfARadius) {
  VoxelMap map = wide_map();
  const Vector3 center_m = map.grid().center_m(map.grid().min_cell);  // the first of all voxels
  map.set(map.grid().index(map.grid().min_cell), -1.0F);
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 p_m = center_m + 0.5 * Vector3::Unit(axis);
    EXPECT_TRUE(map.occupied_within(p_m, 0.5));
    EXPECT_FALSE(map.occupied_within(p_m, 0.499));
  }
  EXPECT_TRUE(map.occupied_within(center_m, 0.01));
}

}  // namespace
}  // namespace swiftlet
