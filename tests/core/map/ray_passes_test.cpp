// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "swiftlet/core/map/voxel_map.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

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
