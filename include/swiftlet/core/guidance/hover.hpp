// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// Holds one position: the start, or a given point. The mission is endless.
struct HoverConfig : ModuleConfigOf<HoverConfig> {
  enum class At { kStart, kPoint };
  At at = At::kStart;
  Eigen::Vector3d point_m = {0.0, 0.0, 2.0};
  double yaw_deg = 0.0;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_hover(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
