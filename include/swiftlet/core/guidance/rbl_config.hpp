// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/core/guidance/neighbor_source.hpp"
#include "swiftlet/core/guidance/rbl_obstacles.hpp"
#include "swiftlet/core/guidance/rbl_planner.hpp"
#include "swiftlet/core/guidance/separation_config.hpp"
#include "swiftlet/core/planning/clear_path.hpp"

namespace swiftlet {

/// Escape from dead ends. Not in the document.
struct RblDetourConfig {
  bool enabled = true;
  double patience_s = 3.0;
  double climb_m = 1.0;  ///< [m] largest height difference of the path to the vehicle; near the goal, also to the goal
  double planning_latency_s = 0.5;
  double retry_after_s = 2.0;
  int retries = 3;
  ClearPathConfig planner;

  /// The exit of a dead end is not in view, so unknown space counts as free. Any path suffices, so the search is
  /// greedy.
  RblDetourConfig() {
    planner.clearance_m = 0.75;
    planner.unknown_is_free = true;
    planner.heuristic_weight = 1.5;
    planner.max_expansions = 200'000;
  }
  void visit(ConfigVisitor& v);
};

/// Rule-based Lloyd algorithm in 2D and 3D [Kamler 2025; Boldrer 2023]: each vehicle flies to the weighted centroid of
/// its own cell, without communication. Defaults: Table 2.2. The mission is done when the goal is reached; the vehicle
/// then continues to keep its cell. It is also done, with a note, when other vehicles occupy the goal.
struct RblConfig : ModuleConfigOf<RblConfig> {
  enum class Variant { k2d, k3d, k3dClipped, k3dZ };
  std::string model;
  static constexpr const char* kVariants[] = {"2d", "3d", "3d_clipped", "3d_z"};
  Variant variant = Variant::k3dZ;
  Eigen::Vector3d goal_m = {0.0, 0.0, 2.0};
  double arrival_radius_m = 0.2;
  double settle_s = 8.0;
  double speed_mps = 4.0;
  double ground_m = 0.0;
  double z_min_m = 1.0;
  double z_max_m = 10.0;
  RblCellConfig cells;
  RblRules rules;
  SeparationConfig separation;
  NeighborSourceConfig neighbors;
  RblLidarConfig lidar;
  RblDetourConfig detour;

  /// With `separation` the cells need not keep vehicles apart alone, so the weighting is narrower than the document's.
  RblConfig() { rules.beta_desired_m = 0.4; }
  void visit(ConfigVisitor& v) override;
};

}  // namespace swiftlet
