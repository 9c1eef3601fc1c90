// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/walls.hpp"

#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

#include "tests/sim/world/world_support.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3d;

WallsConfig maze_of(int columns, int rows) {
  WallsConfig config;
  config.maze.columns = columns;
  config.maze.rows = rows;
  config.maze.first_m = {1.0, -2.0};
  return config;
}

/// Openings between cells of a maze, by rays from middle to middle.
std::vector<std::pair<int, int>> openings(const Scene& scene, const MazeConfig& maze) {
  std::vector<std::pair<int, int>> found;
  for (int row = 0; row < maze.rows; ++row) {
    for (int column = 0; column < maze.columns; ++column) {
      const Vector3d middle_m(maze.first_m.x() + maze.cell_m * column, maze.first_m.y() + maze.cell_m * row, 1.5);
      const int cell = row * maze.columns + column;
      const auto opens = [&](const Vector3d& direction) {
        const auto hit = test::trace(scene, middle_m, direction);
        return !hit || hit->range_m > maze.cell_m;
      };
      if (opens(Vector3d::UnitX())) found.emplace_back(cell, cell + 1);
      if (opens(Vector3d::UnitY())) found.emplace_back(cell, cell + maze.columns);
      if (column == 0) {
        EXPECT_FALSE(opens(-Vector3d::UnitX())) << "out of the maze";
      }
      if (row == 0) {
        EXPECT_FALSE(opens(-Vector3d::UnitY())) << "out of the maze";
      }
    }
  }
  return found;
}

std::size_t num_reached(const std::vector<std::pair<int, int>>& passages) {
  std::set<int> reached = {0};
  for (std::size_t before = 0; before != reached.size();) {
    before = reached.size();
    for (const auto& [a, b] : passages) {
      if (reached.contains(a) || reached.contains(b)) reached.insert({a, b});
    }
  }
  return reached.size();
}

TEST(Walls, FormPerfectMazeWithoutExit) {
  const WallsConfig config = maze_of(5, 4);
  std::set<std::vector<std::pair<int, int>>> mazes;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto passages = openings(make_walls(config, seed), config.maze);
    EXPECT_EQ(passages.size(), 5U * 4U - 1U) << "a tree";
    EXPECT_EQ(num_reached(passages), 20U);
    mazes.insert(passages);
  }
  EXPECT_EQ(mazes.size(), 3U) << "another one for each seed";
}

TEST(Walls, HaveAlternativePathsWithLoops) {
  WallsConfig config = maze_of(5, 4);
  config.maze.loops = 0.5;
  EXPECT_GT(openings(make_walls(config, 1), config.maze).size(), 22U);
  config.maze.loops = 1.0;
  EXPECT_EQ(openings(make_walls(config, 1), config.maze).size(), 4U * 4U + 5U * 3U);
}

TEST(Walls, StandBetweenCornersWithSetDimensions) {
  WallsConfig config;
  config.thickness_m = 0.4;
  config.walls.push_back({{Vector3d(4, -3, 0), Vector3d(4, 3, 0), Vector3d(0, 3, 0)}, 2.5});
  const Scene scene = make_walls(config, 1);
  EXPECT_NEAR(test::trace(scene, {0, 0, 1}, Vector3d::UnitX())->range_m, 3.8, 1e-4);
  EXPECT_NEAR(test::trace(scene, {2, 0, 1}, Vector3d::UnitY())->range_m, 2.8, 1e-4);
  EXPECT_FALSE(test::trace(scene, {0, 0, 2.6}, Vector3d::UnitX()));
  EXPECT_FALSE(test::trace(scene, {0, -3.3, 1}, Vector3d::UnitX()));
  EXPECT_NEAR(test::trace(scene, {4, 0, 5}, -Vector3d::UnitZ())->range_m, 2.5, 1e-4);
}

}  // namespace
}  // namespace swiftlet::sim
