// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// Takeoff, hover, landing, motors off. Done when landed.
struct TakeoffLandConfig : ModuleConfigOf<TakeoffLandConfig> {
  double altitude_m = 2.0;
  double hover_s = 5.0;
  double climb_speed_mps = 1.0;
  double landing_speed_mps = 0.5;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_takeoff_land(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
