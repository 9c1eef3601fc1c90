// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/world/clutter_config.hpp"
#include "swiftlet/sim/world/keep_clear_config.hpp"
#include "swiftlet/sim/world/relief_config.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Open grassland with scattered trees, as for the outdoor flights of Vrba 2025.
struct FieldConfig : ModuleConfigOf<FieldConfig> {
  Eigen::Vector2d size_m = {120.0, 120.0};
  ReliefConfig relief;
  double ground_cell_m = 1.0;
  int num_trees = 12;
  double min_distance_m = 8.0;
  int num_bushes = 20;
  double clear_radius_m = 20.0;
  double detail = 1.0;
  FoliageConfig foliage;
  KeepClearConfig keep_clear;
  ClutterConfig clutter;

  void visit(ConfigVisitor& v) override;
};

Scene make_field(const FieldConfig& config, std::uint64_t seed);

}  // namespace swiftlet::sim
