// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/free_space.hpp"

#include <gtest/gtest.h>

namespace swiftlet {
namespace {

CellGrid small_grid() {
  CellGrid grid;
  grid.origin_world_m = {-1.0, 2.0, 0.5};
  grid.cell_m = 0.5;
  grid.size = {4, 3, 5};
  return grid;
}

TEST(CellGrid, NumbersCellsInXyzOrder) {
  const CellGrid grid = small_grid();
  EXPECT_EQ(grid.num_cells(), 60U);
  int index = 0;
  for (int z = 0; z < 5; ++z) {
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 4; ++x, ++index) {
        const Eigen::Vector3i cell(x, y, z);
        ASSERT_EQ(grid.index_of(cell), index);
        ASSERT_EQ(grid.cell_of(index), cell);
        const Vector3 center(-1.0 + 0.5 * x + 0.25, 2.0 + 0.5 * y + 0.25, 0.5 + 0.5 * z + 0.25);
        ASSERT_LT((grid.center_of(index) - center).norm(), 1e-12);
        ASSERT_EQ(grid.cell_at(center + Vector3::Constant(0.24)), cell);
        ASSERT_EQ(grid.cell_at(center - Vector3::Constant(0.24)), cell);
      }
    }
  }
}

TEST(CellGrid, AssignsOutsidePointsToNearestCell) {
  const CellGrid grid = small_grid();
  EXPECT_EQ(grid.cell_at({-9.0, 2.6, 99.0}), Eigen::Vector3i(0, 1, 4));
  EXPECT_EQ(grid.cell_at({9.0, 99.0, -9.0}), Eigen::Vector3i(3, 2, 0));
}

/// Free except for a slab across x.
class Slab : public FreeSpaceView {
 public:
  Slab(double from_m, double to_m) : from_m_(from_m), to_m_(to_m) {}
  const CellGrid& grid() const override { return grid_; }
  bool is_free(const Vector3& p_world_m) const override { return p_world_m.x() < from_m_ || p_world_m.x() > to_m_; }
  bool is_free_cell(int) const override { return true; }

 private:
  CellGrid grid_ = small_grid();
  double from_m_, to_m_;
};

TEST(FreeSegment, DetectsHalfACellAnywhere) {
  for (int i = 0; i <= 140; ++i) {
    const double from_m = 0.02 * i;
    EXPECT_FALSE(is_free_segment(Slab(from_m, from_m + 0.25), {0, 0, 0}, {3, 0, 0})) << from_m;
  }
}

TEST(FreeSegment, IncludesBothEnds) {
  EXPECT_FALSE(is_free_segment(Slab(-0.1, 0.01), {0, 0, 0}, {3, 0, 0}));
  EXPECT_FALSE(is_free_segment(Slab(2.99, 3.1), {0, 0, 0}, {3, 0, 0}));
  EXPECT_FALSE(is_free_segment(Slab(-0.1, 0.1), {0, 0, 0}, {0, 0, 0})) << "a point";
  EXPECT_TRUE(is_free_segment(Slab(3.1, 4.0), {0, 0, 0}, {3, 0, 0}));
}

}  // namespace
}  // namespace swiftlet
