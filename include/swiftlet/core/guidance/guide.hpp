// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/planning/team_plan.hpp"

namespace swiftlet {

/// Sequence of goals, each at a fixed displacement from the guided vehicle's position when it is set.
struct GuideAdvanceConfig {
  Eigen::Vector3d step_m = Eigen::Vector3d::Zero();
  double distance_m = 30.0;

  void visit(ConfigVisitor& v);
};

/// Configuration of one of several guided vehicles.
struct GuidedVehicleConfig {
  std::string name = {};
  std::vector<Eigen::Vector3d> goals_m = {};
  std::vector<double> goal_yaws_deg = {};

  void visit(ConfigVisitor& v);
};

/// Guides another vehicle without exteroceptive sensors along a path that is clear in the guide's map [Pritzl 2024].
/// The guide plans for both vehicles while both hover, and flies to a viewpoint from which it observes the path. Then
/// it sends the path in the guided vehicle's body frame, repeatedly, until the goal is reached. With several guided
/// vehicles, one moves and the others hover.
struct GuideConfig : ModuleConfigOf<GuideConfig> {
  /// When the next leg is planned. kAlternate: while both hover [Pritzl 2024]. kAhead: while the guided vehicle flies.
  /// kTogether: as kAhead, and both fly at the same time; the guide sends the part of the path that it observes.
  enum class Motion { kAlternate, kAhead, kTogether };

  std::string secondary;
  std::vector<GuidedVehicleConfig> secondaries;
  std::vector<Eigen::Vector3d> goals_m;
  std::vector<double> goal_yaws_deg;
  GuideAdvanceConfig advance;
  bool loop = false;
  bool periodic = true;
  Motion motion = Motion::kAlternate;
  double visited_m = 0.2;
  double speed_mps = 1.0;
  double planning_latency_s = 0.5;
  double settle_s = 1.0;
  double link_timeout_s = 1.5;
  double sigma_max_m = 0.4;
  double stage_timeout_s = 60.0;
  int retries = 5;
  TeamPlannerConfig planner;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_guide(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
