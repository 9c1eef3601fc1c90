// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/control/controller.hpp"
#include "swiftlet/core/control/motion_limits.hpp"

namespace swiftlet {

/// Motion limits and controller gains of a vehicle.
struct ControlConfig {
  MotionLimitsConfig limits;
  ControlGainsConfig gains;

  void visit(ConfigVisitor& v) {
    v.object("limits", limits, "motion limits of the reference");
    v.object("gains", gains, "controller gains");
  }
};

}  // namespace swiftlet
