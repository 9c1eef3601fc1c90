// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/enclosure.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

VoxelMapConfig box(double size_m) {
  VoxelMapConfig config;
  config.extent = VoxelMapConfig::Extent::kBounded;
  config.size_m.setConstant(size_m);
  return config;
}

/// Rule B by relaxation to a fixed point, independently from every start.
bool leads_out_slowly(const VoxelMap& map, const Cell& start, const SearchShape& shape) {
  const VoxelGrid& grid = map.grid();
  const auto is_border = [&](const Cell& cell) {
    if (shape.octahedron) return (cell - start).cwiseAbs().sum() >= shape.radius_steps - 1;
    return grid.edge_m * (cell - start).cast<double>().norm() >= shape.radius_m;
  };
  if (map.state(grid.index(start)) == VoxelState::kFree) return false;
  std::set<std::ptrdiff_t> part = {grid.index(start)};
  for (bool grew = true; grew;) {
    grew = false;
    for (const std::ptrdiff_t index : std::set<std::ptrdiff_t>(part)) {
      const Cell cell = grid.cell(index);
      if (map.state(index) >= VoxelState::kTentative || is_border(cell)) return true;
      for (int a = 0; a < 6; ++a) {
        Cell next = cell;
        next[a / 2] += a % 2 == 0 ? 1 : -1;
        if (!grid.contains(next)) return true;
        if (map.state(grid.index(next)) != VoxelState::kFree) grew = part.insert(grid.index(next)).second || grew;
      }
    }
  }
  return false;
}

TEST(EnclosureSearch, MatchesFloodFillInRandomMaps) {
  const Random random(1, "flood");
  EnclosureSearch search;
  int enclosed = 0, out = 0;
  for (std::uint32_t trial = 0; trial < 400; ++trial) {
    VoxelMap map(box(5.0));
    const double free_share = 0.5 + 0.5 * random.uniform(trial, 0);
    for (std::ptrdiff_t i = 0; i < map.grid().num_cells(); ++i) {
      const double u = random.uniform(trial, 10 + static_cast<std::uint32_t>(i));
      if (u < free_share)
        map.set(i, -1000.0F);
      else if (u > 0.999)
        map.set(i, 0.0F);
    }
    SearchShape shape{.octahedron = trial % 3 == 0,
                      .radius_m = 0.5 + random.uniform(trial, 1),
                      .radius_steps = static_cast<int>(trial / 3 % 8)};
    std::vector<Cell> starts;
    for (std::uint32_t k = 0; k < 1 + trial % 5; ++k) {
      starts.emplace_back(static_cast<int>(6.0 * random.uniform(trial, 2 + k)) - 3, static_cast<int>(k % 2), 0);
    }
    bool leads_out = false;
    for (const Cell& start : starts) leads_out = leads_out || leads_out_slowly(map, start, shape);
    ASSERT_EQ(search.enclosed(map, starts, shape), !leads_out) << "trial " << trial;
    (leads_out ? out : enclosed)++;
  }
  EXPECT_GT(enclosed, 50);
  EXPECT_GT(out, 50);
}

TEST(EnclosureSearch, FreeShellEnclosesUntilItLeaks) {
  VoxelMap map(box(8.0));
  const auto at = [&](int x, int y, int z) { return map.grid().index({x, y, z}); };
  for (int z = -3; z <= 3; ++z) {
    for (int y = -3; y <= 3; ++y) {
      for (int x = -3; x <= 3; ++x) {
        if (std::max({std::abs(x), std::abs(y), std::abs(z)}) == 3) map.set(at(x, y, z), -1000.0F);
      }
    }
  }
  EnclosureSearch search;
  const std::vector<Cell> starts = {Cell::Zero()};
  const SearchShape shape{.radius_m = 3.0};
  EXPECT_TRUE(search.enclosed(map, starts, shape));
  map.set(at(2, 2, 3), -740.0F);  // a hole off the straight line
  EXPECT_FALSE(search.enclosed(map, starts, shape));
  map.set(at(2, 2, 3), -1000.0F);
  map.set(at(1, 1, 1), -200.0F);  // something tentative inside
  EXPECT_FALSE(search.enclosed(map, starts, shape));
}

TEST(EnclosureSearch, TreatsTheMapBorderAsOpen) {
  VoxelMap map(box(2.0));
  EnclosureSearch search;
  const SearchShape shape{.radius_m = 50.0};
  EXPECT_FALSE(search.enclosed(map, std::vector<Cell>{Cell::Zero()}, shape));
  EXPECT_FALSE(search.enclosed(map, std::vector<Cell>{Cell(100, 0, 0)}, shape));
  EXPECT_TRUE(search.enclosed(map, {}, shape));
}

}  // namespace
}  // namespace swiftlet
