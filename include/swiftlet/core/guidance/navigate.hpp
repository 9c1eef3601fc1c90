// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/guidance/separation_config.hpp"
#include "swiftlet/core/planning/sampled_path.hpp"

namespace swiftlet {

/// Single-vehicle navigation from goal to goal along paths that are clear in its own map [Orsulic 2021, sec. IV]. The
/// vehicle plans while it hovers, and again when the map shows an obstacle on the rest of its path.
struct NavigateConfig : ModuleConfigOf<NavigateConfig> {
  std::vector<Eigen::Vector3d> goals_m;
  int rounds = 1;
  enum class Search { kAStar, kRrt, kInformedRrtStar };
  Search search = Search::kAStar;
  enum class Follow { kCorners, kTimed };
  Follow follow = Follow::kTimed;
  double speed_mps = 1.0;
  double visited_m = 0.2;
  double planning_latency_s = 0.5;
  double stage_timeout_s = 60.0;
  int retries = 5;
  /// [s] delay after a failure until the next plan; larger values wait longer for obstacles to move away
  double retry_after_s = 2.0;
  ClearPathConfig planner;
  SamplingConfig sampling;
  KeepApartConfig separation;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_navigate(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
