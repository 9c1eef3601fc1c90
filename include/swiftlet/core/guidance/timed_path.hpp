// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/planning/uniform_spline.hpp"

namespace swiftlet {

/// A path planned in advance with its times, flown as a spline with its exact velocity and acceleration. The
/// configuration must ensure that meeting points and clearances are safe.
struct TimedPathConfig : ModuleConfigOf<TimedPathConfig> {
  std::vector<Eigen::Vector3d> points_m;
  double interval_s = 0.5;
  enum class Yaw { kAlongPath, kFixed };
  Yaw yaw = Yaw::kAlongPath;
  double yaw_deg = 0.0;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_timed_path(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
