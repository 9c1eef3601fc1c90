// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// Takes off, hovers above the start, lands and turns the motors off. The mission is done once the vehicle has landed.
struct TakeoffLandConfig : ModuleConfigOf<TakeoffLandConfig> {
  double altitude_m = 2.0;  ///< [m] height of the hover above the start
  double hover_s = 5.0;
  double climb_speed_mps = 1.0;
  double landing_speed_mps = 0.5;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_takeoff_land(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
