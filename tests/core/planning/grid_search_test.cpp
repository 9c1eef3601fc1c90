// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/grid_search.hpp"

#include <gtest/gtest.h>

#include "tests/core/planning/box_space.hpp"

namespace swiftlet {
namespace {

using testing::BoxSpace;
using testing::length_m;

bool wall_with_gap(const Vector3& p) { return std::abs(p.x()) < 0.6 && p.y() < 6.0; }

TEST(GridSearch, FliesStraightThroughFreeSpace) {
  const BoxSpace box([](const Vector3&) { return false; });
  const PathResult path = find_path(box, {-8, -7, 1}, {8, 7, 3});
  EXPECT_EQ(path.status, PathStatus::kFound);
  EXPECT_EQ(path.corners_world_m, (std::vector<Vector3>{{-8, -7, 1}, {8, 7, 3}}));
}

TEST(GridSearch, FindsShortFreePathAroundWall) {
  const BoxSpace box(wall_with_gap);
  const PathResult path = find_path(box, {-8, -5, 1}, {8, -5, 1});
  ASSERT_EQ(path.status, PathStatus::kFound);
  // Between two free cells a path may enter occupied cells by half a cell.
  const BoxSpace core([](const Vector3& p) { return std::abs(p.x()) < 0.3 && p.y() < 5.7; });
  for (std::size_t i = 1; i < path.corners_world_m.size(); ++i) {
    EXPECT_TRUE(is_free_segment(core, path.corners_world_m[i - 1], path.corners_world_m[i]));
  }
  // Around both corners of the wall: 2 hypot(8 - 0.6, 11) + 1.2.
  EXPECT_GE(length_m(path.corners_world_m), 27.7);
  EXPECT_LE(length_m(path.corners_world_m), 29.5);
  EXPECT_EQ(find_path(box, {-8, -5, 1}, {8, -5, 1}).corners_world_m, path.corners_world_m);
}

TEST(GridSearch, ExplainsMissingPath) {
  const BoxSpace gap(wall_with_gap), wall([](const Vector3&p) { return std::abs(p.x()) < 0.6; });
  EXPECT_EQ(find_path(gap, {0, 0, 1}, {8, 0, 1}).status, PathStatus::kStartNotFree);
  EXPECT_EQ(find_path(gap, {8, 0, 1}, {0, 0, 1}).status, PathStatus::kGoalNotFree);
  EXPECT_EQ(find_path(wall, {-8, 0, 1}, {8, 0, 1}).status, PathStatus::kNoPath);
  EXPECT_EQ(find_path(gap, {-8, 0, 1}, {8, 0, 1}, 20).status, PathStatus::kBudgetSpent);
  EXPECT_TRUE(find_path(gap, {-8, 0, 1}, {8, 0, 1}, 20).corners_world_m.empty());
}

TEST(GridSearch, StaysWhenGoalSharesItsCell) {
  const BoxSpace box(wall_with_gap);
  const PathResult path = find_path(box, {5.1, 5.1, 1.1}, {5.3, 5.2, 1.2});
  EXPECT_EQ(path.corners_world_m, (std::vector<Vector3>{{5.1, 5.1, 1.1}, {5.3, 5.2, 1.2}}));
}

}  // namespace
}  // namespace swiftlet
