// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// An indoor area with a free-standing solid wall (keys hide_*) that occludes targets [Vrba 2025, sec. V-B]. In the
/// default size, vehicles at least a meter from the outer walls, floor and ceiling are at most 16 m apart, the maximum
/// of the multi-UAV experiment (Table IV). Crates stand along the outer walls only.
struct HallConfig : ModuleConfigOf<HallConfig> {
  Eigen::Vector3d size_m = {15.0, 10.0, 6.0};
  Eigen::Vector2d hide_center_m = {1.5, 0.0};
  double hide_length_m = 4.0;
  double hide_height_m = 0.0;
  double hide_yaw_deg = 90.0;
  int num_crates = 8;

  void visit(ConfigVisitor& v) override;
};

Scene make_hall(const HallConfig& config, std::uint64_t seed);

}  // namespace swiftlet::sim
