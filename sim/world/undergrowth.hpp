// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "sim/world/dice.hpp"
#include "sim/world/scene_builder.hpp"

namespace swiftlet::sim {

/// A stock of bushes and clumps of grass. Radius about 0.6 m (bush) and 0.35 m (grass) before scaling.
class UndergrowthStock {
 public:
  UndergrowthStock(SceneBuilder& scene, double detail, const Random& random);

  enum class Kind { kBush, kGrass };
  /// Largest extent of a plant of this scale from its foot [m].
  double reach_m(Kind kind, double scale) const;
  void place(SceneBuilder& scene, Kind kind, const Eigen::Vector3d& foot_world_m, double scale, Dice& dice) const;

 private:
  std::vector<std::uint32_t> bushes_, grass_;
  double bush_reach_m_ = 0.0, grass_reach_m_ = 0.0;
};

}  // namespace swiftlet::sim
