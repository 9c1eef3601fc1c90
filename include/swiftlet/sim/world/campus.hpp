// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/world/clutter_config.hpp"
#include "swiftlet/sim/world/keep_clear_config.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// A small building to fly around, as in [Orsulic 2021], with gabled roof, windows, doors, chimney and steps. A paved
/// path with kerbs surrounds it; farther out is a lawn with trees, lamp posts and parked cars. Only kerbs stand nearer
/// to the walls than 9 m, so that a circle in that ring is free for every seed.
struct CampusConfig : ModuleConfigOf<CampusConfig> {
  Eigen::Vector2d size_m = {90.0, 90.0};
  Eigen::Vector2d building_size_m = {14.0, 9.0};
  double wall_height_m = 4.5;
  double roof_height_m = 2.8;
  int num_trees = 22;
  int num_lamps = 8;
  int num_cars = 5;
  double detail = 1.0;
  FoliageConfig foliage;
  KeepClearConfig keep_clear;
  ClutterConfig clutter;

  void visit(ConfigVisitor& v) override;
};

Scene make_campus(const CampusConfig& config, std::uint64_t seed);

}  // namespace swiftlet::sim
