// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/world/keep_clear_config.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// The forest of [Kamler 2025, sec. 3.4]: 100 trees at least 3 m apart on a flat area, trunks as cylinders, crowns as
/// spheres. The thesis gives "0.5 +- 0.2 m" without naming a distribution; here it is uniform with that half-width.
/// The distance between trees is that of their axes. The trunk is as long as the tree is high, and the crown is
/// centered on its top. The flight from z = 2 m to 5 m thus passes below most of it, as Fig. 3.4 shows.
struct ForestThesisConfig : ModuleConfigOf<ForestThesisConfig> {
  Eigen::Vector2d area_min_m = {-20.0, -32.0};
  Eigen::Vector2d area_max_m = {20.0, 32.0};
  int num_trees = 100;
  double min_distance_m = 3.0;
  double trunk_radius_m = 0.5;
  double trunk_radius_spread_m = 0.2;
  double tree_height_m = 7.5;
  double tree_height_spread_m = 2.0;
  double crown_radius_m = 2.5;
  double crown_radius_spread_m = 0.5;
  KeepClearConfig keep_clear;

  void visit(ConfigVisitor& v) override;
};

Scene make_forest_thesis(const ForestThesisConfig& config, std::uint64_t seed);

}  // namespace swiftlet::sim
