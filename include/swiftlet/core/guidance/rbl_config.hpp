// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/guidance/neighbor_source.hpp"
#include "swiftlet/core/guidance/separation_config.hpp"
#include "swiftlet/core/planning/clear_path.hpp"

namespace swiftlet {

/// Cells of the rule-based Lloyd algorithm [Kamler 2025, Tables 2.2 and 3.1].
struct RblCellConfig {
  double sensing_radius_m = 3.5;  ///< r_s
  double step_m = 0.2;
  enum class Lattice { kAgent, kWorld };
  Lattice lattice = Lattice::kAgent;
  double encumbrance_m = 0.5;  ///< delta_i, equal for all vehicles
  double eta = 0.9;
  enum class Cut { kProgram, kBuffered, kContinued };
  Cut cut = Cut::kProgram;

  void visit(ConfigVisitor& v);
};

/// Rules of the 3D rule-based Lloyd algorithm [Kamler 2025, eqs. 2.7 to 2.20]. Where the document is ambiguous or
/// differs from its authors' program, the interpretation is an option, or fixed (docs/rbl.md).
struct RblRules {
  double weight_near_m = 0.5;       ///< d_1
  double weight_gap_m = 1.0;        ///< d_2
  double weight_goal_m = 3.5;       ///< goal distance below which beta falls too; 0: never, as in the document
  double azimuth_near_m = 0.5;      ///< d_3
  double azimuth_gap_m = 1.0;       ///< d_4
  double elevation_near_m = 0.5;    ///< d_5
  double elevation_gap_m = 1.0;     ///< d_6
  double elevation_shrink_m = 0.2;  ///< d_7
  double beta_desired_m = 1.5;      ///< beta^D
  double beta_min_m = 0.1;          ///< beta_min; not in the document
  double weight_rate_mps = 1.0;     ///< k of (2.7)
  double azimuth_rate_radps = 1.0;  ///< k of (2.8)
  double azimuth_return_radps = 2.0;
  double elevation_rate_radps = 1.0;  ///< k of (2.19)
  double centering_weight = 0.7;      ///< w_1
  double direction_weight = 0.3;      ///< w_2
  enum class AzimuthCondition { kNear, kPrinted };
  AzimuthCondition azimuth_condition = AzimuthCondition::kNear;
  enum class AzimuthReset { kDetour, kNear, kNone };
  AzimuthReset azimuth_reset = AzimuthReset::kDetour;
  enum class ElevationCondition { kGap, kPrinted };
  ElevationCondition elevation_condition = ElevationCondition::kGap;
  enum class DirectionInfluence { kNorth, kPrinted, kProgram };
  DirectionInfluence direction_influence = DirectionInfluence::kNorth;
  enum class ElevationSense { kLevel, kUp, kPrinted };
  ElevationSense elevation_sense = ElevationSense::kLevel;
  bool azimuth_rule = true;
  bool elevation_rule = true;  ///< z-rule (2.15) to (2.19); RblConfig enables it for the variant 3d_z only

  void visit(ConfigVisitor& v);
};

/// LiDAR mode of the rule-based Lloyd algorithm [Kamler 2025, chapter 3]. Defaults: Table 3.1 and the released program.
struct RblLidarConfig {
  bool enabled = false;
  enum class Legal { kSensed, kCell };
  Legal legal = Legal::kSensed;
  double fov_lower_deg = 20.0;
  double fov_deg = 59.0;
  double facing_deg = 60.0;

  void visit(ConfigVisitor& v);
};

/// Escape from dead ends. Not in the document.
struct RblDetourConfig {
  bool enabled = true;
  double patience_s = 3.0;
  double climb_m = 1.0;  ///< [m] largest height difference of the path to the vehicle; near the goal, also to the goal
  double planning_latency_s = 0.5;
  /// [s] delay after a search without a path before the next one; larger values wait longer for others to move away
  double retry_after_s = 2.0;
  int retries = 3;  ///< [-] searches without a path, after the first one, before the mission has failed
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
