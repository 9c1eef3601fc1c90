// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/clear_path.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/planning/path_timing.hpp"
#include "tests/core/planning/box_map.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using testing::BoxMap;

/// Length of the shortest path between cells by Dijkstra's algorithm, infinite when there is none.
double shortest_m(const BoxMap& map, const std::vector<bool>& clear, const Cell& start, const Cell& goal) {
  const VoxelGrid& grid = map.grid();
  std::vector<double> cost(clear.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, std::ptrdiff_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  cost[static_cast<std::size_t>(grid.index(start))] = 0.0;
  open.push({0.0, grid.index(start)});
  while (!open.empty()) {
    const auto [so_far, index] = open.top();
    open.pop();
    if (so_far > cost[static_cast<std::size_t>(index)]) continue;
    for (int i = 0; i < 27; ++i) {
      const Cell step(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1), to = grid.cell(index) + step;
      if (!grid.contains(to) || !clear[static_cast<std::size_t>(grid.index(to))]) continue;
      const double next = so_far + std::sqrt(static_cast<double>(step.squaredNorm()));
      if (next >= cost[static_cast<std::size_t>(grid.index(to))] - 1e-12) continue;
      cost[static_cast<std::size_t>(grid.index(to))] = next;
      open.push({next, grid.index(to)});
    }
  }
  return cost[static_cast<std::size_t>(grid.index(goal))] * grid.edge_m;
}

/// Cells with more than the clearance, by a search over all occupied cells.
std::vector<bool> clear_cells(const BoxMap& map, double clearance_m) {
  std::vector<Vector3> occupied_m;
  const Vector3 size_m = map.grid().size.cast<double>() * map.edge_m();
  map.occupied_in(Vector3::Zero(), size_m, occupied_m);
  std::vector<bool> clear;
  for (std::ptrdiff_t i = 0; i < map.grid().num_cells(); ++i) {
    const Vector3 center_m = map.grid().center_m(map.grid().cell(i));
    clear.push_back(map.at(map.grid().cell(i)) != CellState::kUnknown &&
                    std::all_of(occupied_m.begin(), occupied_m.end(),
                                [&](const Vector3& cell_m) { return (cell_m - center_m).norm() > clearance_m; }));
  }
  return clear;
}

BoxMap random_box(std::uint32_t k) {
  const Random random(k, "map");
  BoxMap map({14, 12, 8}, 0.2);
  for (std::ptrdiff_t i = 0; i < map.grid().num_cells(); ++i) {
    const double u = random.uniform(0, static_cast<std::uint32_t>(i));
    map.at(map.grid().cell(i)) = u < (k % 3 == 0 ? 0.04 : 0.025) ? CellState::kOccupied
                                 : u < 0.05                      ? CellState::kUnknown
                                                                 : CellState::kFree;
  }
  return map;
}

TEST(ClearPath, MatchesDijkstraLengthOnRandomGrids) {
  int found = 0, none = 0;
  for (std::uint32_t k = 0; k < 60; ++k) {
    const BoxMap map = random_box(k);
    ClearPathConfig config;
    config.clearance_m = k % 2 == 0 ? 0.25 : 0.42;
    config.max_shortenings = 0;
    const std::vector<bool> clear = clear_cells(map, config.clearance_m);
    std::vector<std::ptrdiff_t> free;
    for (std::size_t i = 0; i < clear.size(); ++i) {
      if (clear[i]) free.push_back(static_cast<std::ptrdiff_t>(i));
    }
    const Cell start = map.grid().cell(free.front()), goal = map.grid().cell(free.back());
    const ClearPath path = find_clear_path(map, config, map.grid().center_m(start), map.grid().center_m(goal));
    const double expected_m = shortest_m(map, clear, start, goal);
    if (!std::isfinite(expected_m)) {
      ++none;
      EXPECT_NE(path.status, ClearPathStatus::kFound) << k;
      EXPECT_TRUE(path.corners_local_m.empty());
      continue;
    }
    ++found;
    ASSERT_EQ(path.status, ClearPathStatus::kFound) << k;
    EXPECT_NEAR(length_m(path.corners_local_m), expected_m, 1e-9) << k;

    config.max_shortenings = 5;
    const ClearPath shorter = find_clear_path(map, config, map.grid().center_m(start), map.grid().center_m(goal));
    EXPECT_LE(length_m(shorter.corners_local_m), expected_m + 1e-9) << k;
    EXPECT_EQ(shorter.corners_local_m.front(), map.grid().center_m(start));
    EXPECT_EQ(shorter.corners_local_m.back(), map.grid().center_m(goal));
    for (std::size_t i = 1; i < shorter.corners_local_m.size(); ++i) {
      const Vector3 &a = shorter.corners_local_m[i - 1], &b = shorter.corners_local_m[i];
      for (int s = 0; s <= 200; ++s) {
        const Vector3 p_m = a + (b - a) * (s / 200.0);
        const Cell cell = (p_m.array() / 0.2).floor().cast<int>();
        // Where the segment only touches a corner of a cell, rounding may decide.
        const Vector3 inside =
            (p_m / 0.2 - cell.cast<double>()).cwiseMin((cell.cast<double>().array() + 1.0).matrix() - p_m / 0.2);
        if (inside.minCoeff() < 0.2) continue;
        EXPECT_TRUE(clear[static_cast<std::size_t>(map.grid().index(cell))]) << k << ": " << p_m.transpose();
      }
    }
  }
  EXPECT_GT(found, 20);
  EXPECT_GT(none, 3);
}

/// A wall across a room, with a gap in it: 4 m x 3 m x 2 m.
BoxMap gap_in_a_wall(int gap_cells) {
  BoxMap map({40, 30, 20}, 0.1);
  for (int y = 0; y < 30; ++y) {
    for (int z = 0; z < 20; ++z) {
      if (std::abs(y - 22) > gap_cells / 2) map.at({20, y, z}) = CellState::kOccupied;
    }
  }
  return map;
}

TEST(ClearPath, GoesStraightOrThroughAGap) {
  const BoxMap map = gap_in_a_wall(11);
  ClearPathConfig config;
  config.clearance_m = 0.4;
  const Vector3 start(0.55, 0.55, 1.05), beside(1.25, 2.55, 1.25), behind(3.45, 0.55, 1.05);
  const ClearPath straight = find_clear_path(map, config, start, beside);
  EXPECT_EQ(straight.corners_local_m, (std::vector<Vector3>{start, beside}));
  const ClearPath around = find_clear_path(map, config, start, behind);
  ASSERT_EQ(around.status, ClearPathStatus::kFound);
  // A taut string around the edges of the gap, rounded by the clearance, is hardly shorter.
  const double taut_m = 2.0 * (Vector3(2.05, 2.05, 1.05) - start).norm();
  EXPECT_LT(length_m(around.corners_local_m), 1.04 * taut_m);
  EXPECT_LE(around.corners_local_m.size(), 6U);
  config.clearance_m = 0.7;
  EXPECT_EQ(find_clear_path(map, config, start, behind).status, ClearPathStatus::kNoPath) << "too narrow";
}

TEST(ClearPath, ReportsWhyNoneExists) {
  BoxMap map = gap_in_a_wall(11);
  ClearPathConfig config;
  config.clearance_m = 0.4;
  const Vector3 start(0.55, 0.55, 1.05), behind(3.45, 0.55, 1.05);
  EXPECT_EQ(find_clear_path(map, config, start, {2.05, 0.55, 1.05}).status, ClearPathStatus::kGoalBlocked);
  EXPECT_EQ(find_clear_path(map, config, start, {1.75, 0.55, 1.05}).status, ClearPathStatus::kGoalBlocked);
  EXPECT_EQ(find_clear_path(map, config, start, {5.05, 0.55, 1.05}).status, ClearPathStatus::kGoalUnknown);
  config.max_expansions = 50;
  const ClearPath spent = find_clear_path(map, config, start, behind);
  EXPECT_EQ(spent.status, ClearPathStatus::kBudgetSpent);
  EXPECT_EQ(spent.expansions, 50U);
  config.max_expansions = 300'000;
  config.z_max_m = 0.9;
  EXPECT_EQ(find_clear_path(map, config, start, behind).status, ClearPathStatus::kGoalBlocked) << "too high";
  // A goal in an isolated known cell.
  BoxMap dark({20, 20, 20}, 0.1);
  for (std::ptrdiff_t i = 0; i < dark.grid().num_cells(); ++i) dark.at(dark.grid().cell(i)) = CellState::kUnknown;
  for (int x = 14; x < 20; ++x) dark.at({x, 10, 10}) = CellState::kFree;
  config = {};
  config.clearance_m = 0.2;
  EXPECT_EQ(find_clear_path(dark, config, {0.15, 0.15, 0.15}, {1.75, 1.05, 1.05}).status,
            ClearPathStatus::kStartEnclosed);
}

// Displaced as by a gust: 0.2 m from the wall where 0.4 m are required. The path must leave without getting nearer.
TEST(ClearPath, LeavesStartsTooNearToObstacles) {
  const BoxMap map = gap_in_a_wall(11);
  ClearPathConfig config;
  config.clearance_m = 0.4;
  const Vector3 start(1.85, 0.75, 1.05), goal(0.55, 2.05, 1.05);
  const ClearPath path = find_clear_path(map, config, start, goal);
  ASSERT_EQ(path.status, ClearPathStatus::kFound);
  for (std::size_t i = 1; i < path.corners_local_m.size(); ++i) {
    const Vector3 &a = path.corners_local_m[i - 1], &b = path.corners_local_m[i];
    for (int s = 0; s <= 100; ++s) EXPECT_GE(map.clearance_m(a + (b - a) * (s / 100.0), 1.0), 0.2 - 1e-9);
  }
}

TEST(ClearPath, LeavesUnknownStarts) {
  BoxMap map({40, 30, 20}, 0.1);
  for (int x = 3; x < 9; ++x) {
    for (int y = 3; y < 9; ++y) {
      for (int z = 7; z < 13; ++z) map.at({x, y, z}) = CellState::kUnknown;  // another vehicle's returns are left out
    }
  }
  ClearPathConfig config;
  config.clearance_m = 0.4;
  EXPECT_EQ(find_clear_path(map, config, {0.65, 0.65, 1.05}, {3.45, 2.05, 1.05}).status, ClearPathStatus::kFound);
}

TEST(ClearPath, BoundsGreedyLengthByItsFactor) {
  const BoxMap map = gap_in_a_wall(13);
  ClearPathConfig config;
  config.clearance_m = 0.3;
  config.max_shortenings = 0;
  const Vector3 start(0.55, 0.55, 1.05), behind(3.45, 0.55, 1.05);
  const ClearPath best = find_clear_path(map, config, start, behind);
  config.heuristic_weight = 1.5;
  const ClearPath greedy = find_clear_path(map, config, start, behind);
  ASSERT_EQ(greedy.status, ClearPathStatus::kFound);
  EXPECT_LT(greedy.expansions, best.expansions);
  EXPECT_LE(length_m(greedy.corners_local_m), 1.5 * length_m(best.corners_local_m));
}

TEST(ClearPath, StaysClearWhenTimed) {
  const BoxMap map = gap_in_a_wall(13);
  ClearPathConfig config;
  config.clearance_m = 0.45;
  const Vector3 start(0.55, 0.55, 1.05), behind(3.45, 0.55, 1.05);
  const ClearPath path = find_clear_path(map, config, start, behind);
  ASSERT_EQ(path.status, ClearPathStatus::kFound);
  config.clearance_m = 0.3;  // allowance for the rounding of corners
  const ClearSpace space(map, config, start);
  const auto timed = time_path(path.corners_local_m, {}, [&](const Vector3& p_m) { return space.is_clear(p_m); });
  ASSERT_TRUE(timed.has_value());
  const UniformSpline spline = timed->spline();
  for (int i = 0; i <= 200; ++i) {
    EXPECT_GE(map.clearance_m(spline.at(spline.duration_s() * i / 200.0).p_m, 1.0), 0.2);
  }
}

TEST(BlockedPath, DetectsObstaclesNearTheRemainingPart) {
  const std::vector<Vector3> corners = {{0.05, 0.05, 1.05}, {4.05, 0.05, 1.05}, {4.05, 4.05, 1.05}};
  ClearPathConfig config;
  config.clearance_m = 0.5;
  const auto blocked = [&](const Vector3& obstacle_m, const Vector3& p_m, std::size_t next) {
    bool first = false;
    for (const Vector3& off_m : {Vector3(0, 0, 0), Vector3(-7, 3, 1)}) {  // wherever the origin is
      testing::CellListMap map;
      map.occupy_box(obstacle_m + off_m, obstacle_m + off_m + Vector3::Constant(0.1));
      std::vector<Vector3> there;
      for (const Vector3& corner_m : corners) there.push_back(corner_m + off_m);
      const bool now = is_blocked(map, config, p_m + off_m, there, next);
      if (off_m.isZero()) first = now;
      EXPECT_EQ(now, first);
    }
    return first;
  };
  // Center to center; a cell's edge less than planned is enough.
  EXPECT_TRUE(blocked({2.0, 0.3, 1.0}, corners[0], 1));
  EXPECT_FALSE(blocked({2.0, 0.6, 1.0}, corners[0], 1));
  EXPECT_TRUE(blocked({4.0, 3.0, 1.0}, corners[0], 1)) << "on a later leg";
  // Obstacles behind the vehicle are ignored, on this leg and on the one before.
  EXPECT_FALSE(blocked({1.0, 0.0, 1.0}, {2.05, 0.05, 1.05}, 1));
  EXPECT_TRUE(blocked({3.0, 0.0, 1.0}, {2.05, 0.05, 1.05}, 1));
  EXPECT_FALSE(blocked({3.0, 0.0, 1.0}, {4.05, 1.05, 1.05}, 2));
  // A vehicle beside its path is judged by the path.
  EXPECT_FALSE(blocked({2.0, 0.6, 1.0}, {1.05, 0.25, 1.05}, 1));
}

}  // namespace
}  // namespace swiftlet
