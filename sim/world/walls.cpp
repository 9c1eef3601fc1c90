// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/walls.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "sim/world/building.hpp"
#include "sim/world/dice.hpp"
#include "sim/world/materials.hpp"
#include "sim/world/scene_builder.hpp"

namespace swiftlet::sim {
namespace {

// [m] Shortest wall; a shorter one has no direction.
constexpr double kMinLength_m = 1e-3;

/// The cells of a maze, and the walls between them.
class Maze {
 public:
  Maze(int columns, int rows)
      : columns_(columns),
        rows_(rows),
        visited_(static_cast<std::size_t>(columns * rows)),
        east_(visited_.size(), true),
        north_(visited_.size(), true) {}

  /// Digs from the first cell to random unvisited neighbors, with backtracking.
  void dig(Dice& dice) {
    std::vector<std::pair<int, int>> path = {{0, 0}};
    visited_[0] = true;
    while (!path.empty()) {
      const auto [column, row] = path.back();
      std::vector<std::pair<int, int>> fresh;
      for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{0, 1}, std::pair{-1, 0}, std::pair{0, -1}}) {
        const int x = column + dx, y = row + dy;
        if (x >= 0 && y >= 0 && x < columns_ && y < rows_ && !visited_[at(x, y)]) fresh.emplace_back(x, y);
      }
      if (fresh.empty()) {
        path.pop_back();
        continue;
      }
      const auto next = fresh[static_cast<std::size_t>(dice.pick(static_cast<int>(fresh.size())))];
      wall_between(path.back(), next) = false;
      visited_[at(next.first, next.second)] = true;
      path.push_back(next);
    }
  }
  void open(double share, Dice& dice) {
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        if (column + 1 < columns_ && east(column, row) && dice.chance(share)) east_[at(column, row)] = false;
        if (row + 1 < rows_ && north(column, row) && dice.chance(share)) north_[at(column, row)] = false;
      }
    }
  }
  bool east(int column, int row) const { return east_[at(column, row)]; }
  bool north(int column, int row) const { return north_[at(column, row)]; }

 private:
  std::size_t at(int column, int row) const { return static_cast<std::size_t>(row * columns_ + column); }
  std::vector<bool>::reference wall_between(const std::pair<int, int>& a, const std::pair<int, int>& b) {
    const std::size_t low = at(std::min(a.first, b.first), std::min(a.second, b.second));
    return a.second == b.second ? east_[low] : north_[low];
  }

  int columns_, rows_;
  std::vector<bool> visited_, east_, north_;
};

void add_maze(Mesh& mesh, const MazeConfig& config, double thickness_m, std::uint64_t seed) {
  Maze maze(config.columns, config.rows);
  Dice digging(Random(seed, "world.walls.maze"), 0), opening(Random(seed, "world.walls.loops"), 0);
  maze.dig(digging);
  maze.open(config.loops, opening);
  const Eigen::Vector2d corner_m = config.first_m.array() - 0.5 * config.cell_m;
  // Extended by half a thickness at both ends, which fills the corners.
  const auto wall = [&](double from_x, double from_y, double to_x, double to_y) {
    const Eigen::Vector2d from_m = corner_m + config.cell_m * Eigen::Vector2d(from_x, from_y);
    const Eigen::Vector2d to_m = corner_m + config.cell_m * Eigen::Vector2d(to_x, to_y);
    const Eigen::Vector2d over_m = 0.5 * thickness_m * (to_m - from_m).normalized();
    add_wall(mesh, from_m - over_m, to_m + over_m, config.height_m, thickness_m);
  };
  wall(0, 0, config.columns, 0);
  wall(0, 0, 0, config.rows);
  for (int row = 0; row < config.rows; ++row) {
    for (int column = 0; column < config.columns; ++column) {
      if (maze.east(column, row)) wall(column + 1, row, column + 1, row + 1);
      if (maze.north(column, row)) wall(column, row + 1, column + 1, row + 1);
    }
  }
}

}  // namespace

void WallConfig::visit(ConfigVisitor& v) {
  v.field("points_m", points_m, "[m] corners of the wall's middle line; z is not used");
  v.field("height_m", height_m, "[m]", Range::positive());
}

void MazeConfig::visit(ConfigVisitor& v) {
  v.field("columns", columns, "[-] cells along x; 0: there is no maze", Range::between(0, 200));
  v.field("rows", rows, "[-] cells along y", Range::between(0, 200));
  v.field("cell_m", cell_m, "[m] cell size: distance between the middle planes of adjacent walls", Range::positive());
  v.field("first_m", first_m, "[m] middle of the cell with the smallest x and y");
  v.field("height_m", height_m, "[m] height of the walls", Range::positive());
  v.field("loops", loops, "[-] share of the walls that are removed, which creates alternative paths",
          Range::probability());
  v.check((columns > 0) == (rows > 0), "rows", "cells along both axes, or along none");
}

void WallsConfig::visit(ConfigVisitor& v) {
  v.list("walls", walls, "walls along polylines");
  v.object("maze", maze, "a maze, drawn from the seed");
  v.field("thickness_m", thickness_m, "[m] thickness of all walls", Range::positive());
  v.field("size_m", size_m, "[m] extent of the ground along x and y, centered at the origin", Range::positive());
  v.check(maze.columns == 0 || maze.cell_m > thickness_m, "thickness_m", "less than maze.cell_m");
}

Scene make_walls(const WallsConfig& config, std::uint64_t seed) {
  SceneBuilder scene;
  Mesh ground;
  add_floor(ground, -0.5 * config.size_m, 0.5 * config.size_m, 0.0);
  scene.add(std::move(ground), materials::concrete(), SurfaceClass::kGround);
  for (const WallConfig& wall : config.walls) {
    Mesh mesh;
    for (std::size_t i = 1; i < wall.points_m.size(); ++i) {
      const Eigen::Vector2d from_m = wall.points_m[i - 1].head<2>(), to_m = wall.points_m[i].head<2>();
      if ((to_m - from_m).norm() < kMinLength_m) continue;
      const Eigen::Vector2d over_m = 0.5 * config.thickness_m * (to_m - from_m).normalized();
      add_wall(mesh, from_m - over_m, to_m + over_m, wall.height_m, config.thickness_m);
    }
    scene.add(std::move(mesh), materials::plaster(), SurfaceClass::kWall, scene.next_instance(SurfaceClass::kWall));
  }
  if (config.maze.columns > 0) {
    Mesh mesh;
    add_maze(mesh, config.maze, config.thickness_m, seed);
    scene.add(std::move(mesh), materials::plaster(), SurfaceClass::kWall, scene.next_instance(SurfaceClass::kWall));
  }
  return scene.finish();
}

}  // namespace swiftlet::sim
