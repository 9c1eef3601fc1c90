// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/guidance/guarded_reference.hpp"
#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/guidance/neighbor_memory.hpp"
#include "swiftlet/core/guidance/rbl_detour.hpp"
#include "swiftlet/core/guidance/rbl_obstacles.hpp"
#include "swiftlet/core/guidance/rbl_planner.hpp"
#include "swiftlet/core/guidance/rbl_separation.hpp"
#include "swiftlet/core/guidance/rbl_settling.hpp"
#include "swiftlet/core/guidance/rbl_viewed.hpp"

namespace swiftlet {

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
  double update_rate_hz = 10.0;
  double speed_mps = 4.0;
  double ground_m = 0.0;
  double z_min_m = 1.0;
  double z_max_m = 10.0;
  RblCellConfig cells;
  RblRules rules;
  RblSeparationConfig separation;
  NeighborSourceConfig neighbors;
  RblLidarConfig lidar;
  RblDetourConfig detour;

  /// With `separation` the cells need not keep vehicles apart alone, so the weighting is narrower than the document's.
  RblConfig() { rules.beta_desired_m = 0.4; }
  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_rbl(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
