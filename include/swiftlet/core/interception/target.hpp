// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// Intruder to be intercepted: flies in a box with one of the usual motions of benchmarks for interceptors. Parameters
/// that are not configured are drawn from the seed, so each seed gives another trajectory.
struct TargetConfig : ModuleConfigOf<TargetConfig> {
  enum class Motion { kHover, kLine, kCircle, kFigureEight, kRandom, kEvasive };
  Motion motion = Motion::kRandom;
  std::uint64_t seed = 1;
  double speed_mps = 5.0;
  double acceleration_mps2 = 4.0;
  Eigen::Vector3d area_min_m = {-30.0, -30.0, 5.0};
  Eigen::Vector3d area_max_m = {30.0, 30.0, 15.0};
  double radius_m = 8.0;
  double alarm_m = 12.0;

  void visit(ConfigVisitor& v) override;
};

/// Throws std::invalid_argument when speed or acceleration are beyond the motion limits.
std::unique_ptr<Guidance> make_target(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
