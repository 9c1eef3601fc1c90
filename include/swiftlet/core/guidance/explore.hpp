// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/planning/next_view.hpp"

namespace swiftlet {

/// Single-vehicle exploration: the vehicle flies from view to view until no reachable view in a box of the world shows
/// unknown space. It looks around and plans while it hovers, and flies on paths that are clear in its own map.
struct ExploreConfig : ModuleConfigOf<ExploreConfig> {
  Vector3 box_min_world_m{-20, -20, 0};
  Vector3 box_max_world_m{20, 20, 10};
  double speed_mps = 1.5;
  double visited_m = 0.2;
  double look_s = 0.5;
  double planning_latency_s = 0.3;
  double stage_timeout_s = 60.0;
  int retries = 5;
  /// [s] delay after a failure until the next plan; larger values wait longer for obstacles to move away
  double retry_after_s = 2.0;
  NextViewConfig view;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_explore(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
