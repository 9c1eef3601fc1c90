// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/control/controller.hpp"
#include "swiftlet/core/control/motion_limits.hpp"

namespace swiftlet {

/// How a vehicle is flown.
struct ControlConfig {
  MotionLimitsConfig limits;
  ControlGainsConfig gains;

  void visit(ConfigVisitor& v) {
    v.object("limits", limits, "how fast the reference may move");
    v.object("gains", gains, "of the controller");
  }
};

}  // namespace swiftlet
