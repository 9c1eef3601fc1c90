// SPDX-License-Identifier: BSD-3-Clause
// Free space up to each bound, and the cost of searches.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/planning/polyline.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/planning/clear_path.hpp"
#include "swiftlet/core/planning/grid_search.hpp"
#include "tests/core/planning/box_map.hpp"
#include "tests/core/planning/box_space.hpp"

namespace swiftlet {
namespace {

using testing::BoxMap;

constexpr double kCellEdge_m = 0.25;

Vector3 cell_center(int x, int y, int z) { return kCellEdge_m * Vector3(x + 0.5, y + 0.5, z + 0.5); }

TEST(ClearRules, RequireKnownCellsWithSufficientClearance) {
  BoxMap map({20, 20, 12}, kCellEdge_m);
  map.at({10, 10, 6}) = CellState::kOccupied;
  map.at({3, 3, 6}) = CellState::kUnknown;
  ClearPathConfig config;
  config.clearance_m = 0.75;
  config.z_min_m = 0.5;
  config.z_max_m = 2.5;
  const Vector3 start = cell_center(1, 1, 6);
  const ClearSpace space(map, config, start);
  for (int x = 0; x < 20; ++x) {
    for (int y = 0; y < 20; ++y) {
      for (int z = 0; z < 12; ++z) {
        const Vector3 p_m = cell_center(x, y, z);
        const bool far = Vector3(x - 10, y - 10, z - 6).norm() > 3.0;
        const bool clear = far && p_m.z() >= 0.5 && p_m.z() <= 2.5 && !(x == 3 && y == 3 && z == 6);
        ASSERT_EQ(space.is_clear(p_m), clear) << p_m.transpose();
      }
    }
  }
  config.unknown_is_free = true;
  EXPECT_TRUE(ClearSpace(map, config, start).is_clear(cell_center(3, 3, 6)));
  EXPECT_FALSE(space.near_start(start + Vector3(0, 0, 1e-6))) << "a start that is clear needs no ball";
}

TEST(ClearRules, LetBlockedStartsEscape) {
  BoxMap map({40, 20, 12}, kCellEdge_m);
  map.at({10, 10, 6}) = CellState::kOccupied;
  ClearPathConfig config;
  config.clearance_m = 0.8;
  config.z_min_m = 0.5;
  const Vector3 start = cell_center(12, 10, 6);  // 0.5 m from it
  const ClearSpace space(map, config, start);
  EXPECT_TRUE(space.is_clear(start));
  EXPECT_TRUE(space.is_clear(cell_center(8, 10, 6))) << "no nearer to it than the start";
  EXPECT_FALSE(space.is_clear(cell_center(9, 10, 6)));
  EXPECT_FALSE(space.is_clear(start + Vector3(1.4, 0, -1.3))) << "all rules hold away from the start";
  // Where the start is only too low, the full clearance applies too.
  config.z_min_m = 2.0;
  const ClearSpace low(map, config, cell_center(20, 10, 6));
  EXPECT_TRUE(low.is_clear(cell_center(20, 10, 5)));
  EXPECT_TRUE(low.is_clear(cell_center(17, 10, 6)));
}

TEST(ClearRules, CheckEveryCellOfASegment) {
  BoxMap map({20, 20, 12}, kCellEdge_m);
  ClearPathConfig config;
  config.clearance_m = 0.01;
  const Random random(6, "test.segments");
  for (std::uint32_t k = 0; k < 60; ++k) {
    const auto point = [&](std::uint32_t i) {
      return Vector3(random.uniform(0.3, 4.7, k, i), random.uniform(0.3, 4.7, k, i + 1),
                     random.uniform(0.3, 2.7, k, i + 2));
    };
    const Vector3 a = point(0), b = point(3);
    const ClearSpace space(map, config, a);
    EXPECT_TRUE(space.is_clear_segment(a, b));
    // A cell somewhere on it, with a good part of the segment inside.
    const Vector3 on = a + random.uniform(k, 6) * (b - a);
    const Cell cell = (on / kCellEdge_m).array().floor().cast<int>();
    const Vector3 inside = on / kCellEdge_m - cell.cast<double>();
    if (inside.minCoeff() < 0.3 || inside.maxCoeff() > 0.7) continue;
    map.at(cell) = CellState::kOccupied;
    EXPECT_FALSE(ClearSpace(map, config, point(9)).is_clear_segment(a, b)) << k;
    map.at(cell) = CellState::kFree;
  }
  map.at({1, 1, 1}) = CellState::kOccupied;
  const ClearSpace space(map, config, cell_center(9, 9, 9));
  EXPECT_FALSE(space.is_clear_segment(cell_center(1, 1, 1), cell_center(5, 1, 1))) << "its beginning";
  EXPECT_FALSE(space.is_clear_segment(cell_center(5, 1, 1), cell_center(1, 1, 1))) << "its end";
  EXPECT_FALSE(space.is_clear_segment(cell_center(1, 1, 1), cell_center(1, 1, 1)));
  EXPECT_TRUE(space.is_clear_segment(cell_center(2, 1, 1), cell_center(2, 1, 1)));
}

TEST(ClearRules, ExpandOnlyPathCellsWhenUnobstructed) {
  const BoxMap map({24, 24, 24}, kCellEdge_m);
  ClearPathConfig config;
  config.clearance_m = 0.1;
  const Cell start(10, 10, 10);
  for (const Cell& step : {Cell(7, 0, 0), Cell(0, -6, 0), Cell(0, 0, 5), Cell(6, 6, 0), Cell(-5, 5, -5), Cell(7, 3, 2),
                           Cell(2, -8, 5), Cell(-3, 4, 9)}) {
    const Cell goal = start + step;
    const ClearPath path = find_clear_path(map, config, cell_center(start.x(), start.y(), start.z()),
                                           cell_center(goal.x(), goal.y(), goal.z()));
    ASSERT_EQ(path.status, ClearPathStatus::kFound);
    EXPECT_EQ(path.expansions, static_cast<std::size_t>(step.cwiseAbs().maxCoeff())) << step.transpose();
    EXPECT_EQ(path.corners_local_m.size(), 2U);
  }
}

TEST(ClearRules, GiveEachStatusADistinctText) {
  std::vector<std::string> texts;
  for (int i = 0; i <= static_cast<int>(ClearPathStatus::kBudgetSpent); ++i)
    texts.emplace_back(text_of(static_cast<ClearPathStatus>(i)));
  EXPECT_EQ(texts[static_cast<int>(ClearPathStatus::kGoalTooFar)], "the goal is farther away than a map can reach");
  std::sort(texts.begin(), texts.end());
  EXPECT_EQ(std::adjacent_find(texts.begin(), texts.end()), texts.end());
  EXPECT_NE(texts.front(), "");
}

TEST(ClearRules, ReachAMillionCells) {
  EXPECT_TRUE(is_on_map({0, 0, 249'999}, kCellEdge_m));
  EXPECT_FALSE(is_on_map({0, -250'000, 0}, kCellEdge_m));
  EXPECT_FALSE(is_on_map({std::nan(""), 0, 0}, kCellEdge_m));
  const BoxMap map({4, 4, 4}, kCellEdge_m);
  const Vector3 here = cell_center(2, 2, 2), nowhere(300'000, 0, 0);
  ClearPathConfig config;
  EXPECT_EQ(find_clear_path(map, config, here, nowhere).status, ClearPathStatus::kGoalTooFar);
  EXPECT_EQ(find_clear_path(map, config, nowhere, here).status, ClearPathStatus::kGoalTooFar);
}

TEST(GridSearch, IncludesTheBordersOfTheBox) {
  // A wall that leaves only the outermost cells free.
  const testing::BoxSpace box([](const Vector3& p) { return std::abs(p.x()) < 9.4 && std::abs(p.y()) < 9.4; }, 1);
  const PathResult path = find_path(box, {-9.75, -9.75, 0.25}, {9.75, 9.75, 0.25});
  ASSERT_EQ(path.status, PathStatus::kFound);
  EXPECT_LT(testing::length_m(path.corners_world_m), 40.0);
}

}  // namespace
}  // namespace swiftlet
