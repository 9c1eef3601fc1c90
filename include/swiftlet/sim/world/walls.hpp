// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

struct WallConfig {
  std::vector<Eigen::Vector3d> points_m;
  double height_m = 4.0;

  void visit(ConfigVisitor& v);
};

/// A maze of square cells with exactly one path between any two cells, or more with `loops`.
struct MazeConfig {
  int columns = 0;
  int rows = 0;
  double cell_m = 3.0;
  Eigen::Vector2d first_m = Eigen::Vector2d::Zero();
  double height_m = 4.0;
  double loops = 0.0;

  void visit(ConfigVisitor& v);
};

/// Straight walls on a flat ground: a U-shaped trap, a corridor, a maze.
struct WallsConfig : ModuleConfigOf<WallsConfig> {
  std::vector<WallConfig> walls;
  MazeConfig maze;
  double thickness_m = 0.3;
  Eigen::Vector2d size_m = {100.0, 100.0};

  void visit(ConfigVisitor& v) override;
};

Scene make_walls(const WallsConfig& config, std::uint64_t seed);

}  // namespace swiftlet::sim
