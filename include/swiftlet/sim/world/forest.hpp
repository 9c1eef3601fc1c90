// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/world/keep_clear_config.hpp"
#include "swiftlet/sim/world/relief_config.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// A managed mixed forest. Stems: Poisson disks (dart throwing, at least min_spacing_m between axes). Diameters at
/// breast height: Weibull (Bailey and Dell 1973). Heights: Michailow's curve by species with a scatter of 7 %. Crowns:
/// leaf clusters, partly permeable to rays. Trails and clearings only remove the objects inside them, so that the same
/// forest can be flown with and without. A surrounding belt of the same forest with few triangles terminates beams as a
/// continuing forest would; its trees have neither instance nor entry.
struct ForestConfig : ModuleConfigOf<ForestConfig> {
  Eigen::Vector2d size_m = {60.0, 60.0};
  ReliefConfig relief{.amplitude_m = 1.5, .wavelength_m = 30.0, .octaves = 4};
  double ground_cell_m = 0.5;
  double stems_per_ha = 600.0;
  double min_spacing_m = 1.8;
  double dbh_min_m = 0.07;
  double dbh_scale_m = 0.20;
  double pine_share = 0.4;
  double spruce_share = 0.35;
  double broadleaf_share = 0.25;
  double lean_max_deg = 3.0;  ///< [deg] largest lean of the trunks; larger values spread the crowns of tall trees
  double leaf_area_density_per_m = 0.5;
  int variants = 8;
  double bushes_per_ha = 400.0;
  double grass_per_ha = 2000.0;
  double fallen_per_ha = 30.0;
  double rocks_per_ha = 40.0;
  double detail = 1.0;
  double surroundings_m = 30.0;
  FoliageConfig foliage;
  KeepClearConfig keep_clear;

  void visit(ConfigVisitor& v) override;
};

Scene make_forest(const ForestConfig& config, std::uint64_t seed);

}  // namespace swiftlet::sim
