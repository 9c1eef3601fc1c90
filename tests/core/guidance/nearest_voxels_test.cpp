// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/nearest_voxels.hpp"

#include <gtest/gtest.h>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

VoxelGrid grid_of(const Cell& min_cell, const Cell& size) {
  VoxelGrid grid;
  grid.edge_m = 0.2;
  grid.min_cell = min_cell;
  grid.size = size;
  return grid;
}

int distance_sq(const Cell& a, const Cell& b) { return (a - b).squaredNorm(); }

/// Every cell of the box gets a voxel that is there, and none is nearer. Ties may go to either.
void compare_with_all(const std::vector<Cell>& voxels, const VoxelGrid& around, const VoxelGrid& box) {
  std::vector<Vector3> centers_m;
  std::vector<Cell> inside;
  for (const Cell& voxel : voxels) {
    centers_m.push_back(around.center_m(voxel));
    if (around.contains(voxel)) inside.push_back(voxel);
  }
  NearestVoxels nearest;
  nearest.compute(centers_m, around, box);
  ASSERT_EQ(nearest.empty(), inside.empty());
  if (inside.empty()) return;
  for (std::ptrdiff_t i = 0; i < box.num_cells(); ++i) {
    const Cell cell = box.cell(i), found = nearest.nearest(cell - box.min_cell) + around.min_cell;
    ASSERT_NE(std::find(inside.begin(), inside.end(), found), inside.end()) << cell.transpose();
    int least = distance_sq(cell, inside.front());
    for (const Cell& voxel : inside) least = std::min(least, distance_sq(cell, voxel));
    ASSERT_EQ(distance_sq(cell, found), least) << cell.transpose();
  }
}

TEST(NearestVoxels, AreThoseOfASearchThroughAll) {
  const Random random(3, "test.nearest");
  for (std::uint32_t round = 0; round < 60; ++round) {
    std::uint32_t index = 0;
    const auto draw = [&](const Cell& least, const Cell& greatest) {
      Cell drawn;
      for (int axis = 0; axis < 3; ++axis) {
        const double share = random.uniform(round, index++);
        drawn[axis] = least[axis] + static_cast<int>(share * (greatest[axis] - least[axis] + 1));
      }
      return drawn;
    };
    const Cell zero = Cell::Zero(), one = Cell::Ones();
    const Cell min_cell = draw(-30 * one, 10 * one), size = draw(one, 14 * one), from = draw(zero, size - one);
    const VoxelGrid around = grid_of(min_cell, size), box = grid_of(min_cell + from, draw(one, size - from));
    const int count = round % 3 == 0 ? static_cast<int>(round) % 2 : 2 + static_cast<int>(round);
    std::vector<Cell> voxels;
    voxels.reserve(static_cast<std::size_t>(count));
    // Some beside the box: they do not count.
    for (int i = 0; i < count; ++i) voxels.push_back(min_cell + draw(-one, size));
    SCOPED_TRACE(round);
    compare_with_all(voxels, around, box);
  }
}

TEST(NearestVoxels, ASingleVoxelIsTheNearestOfAllWhicheverCornerItIsIn) {
  const VoxelGrid around = grid_of({-4, 3, -2}, {9, 7, 5});
  for (const int x : {0, 8}) {
    for (const int y : {0, 6}) {
      for (const int z : {0, 4}) compare_with_all({around.min_cell + Cell(x, y, z)}, around, around);
    }
  }
}

TEST(NearestVoxels, IsUsedAnewWithoutATraceOfTheBoxBefore) {
  NearestVoxels nearest;
  const VoxelGrid large = grid_of({0, 0, 0}, {12, 12, 12}), small = grid_of({5, 5, 5}, {2, 3, 4});
  nearest.compute(std::vector<Vector3>{large.center_m({0, 0, 0})}, large, large);
  EXPECT_EQ(nearest.nearest({11, 11, 11}), Cell(0, 0, 0));
  nearest.compute(std::vector<Vector3>{small.center_m({6, 5, 8})}, small, small);
  EXPECT_EQ(nearest.nearest({0, 0, 0}), Cell(1, 0, 3));
  nearest.compute({}, small, small);
  EXPECT_TRUE(nearest.empty());
}

TEST(NearestVoxels, LinesMayBeAsLongAsTheyMayBe) {
  for (int axis = 0; axis < 3; ++axis) {
    Cell size = Cell::Ones();
    size[axis] = 1023;
    size[(axis + 1) % 3] = 2;
    const VoxelGrid around = grid_of({-500, -500, -500}, size);
    std::vector<Cell> voxels;
    for (const int along : {0, 1, 255, 511, 512, 700, 1021, 1022}) {
      Cell cell = around.min_cell;
      cell[axis] += along;
      cell[(axis + 1) % 3] += along % 2;
      voxels.push_back(cell);
    }
    compare_with_all(voxels, around, around);
    compare_with_all({voxels.front(), voxels.back()}, around, around);
  }
}

}  // namespace
}  // namespace swiftlet
