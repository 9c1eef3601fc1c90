// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {

/// A vehicle that does not know yet where it is stays where it began and turns, so that its LiDAR sees all around.
class LookAround {
 public:
  void step(double dt_s, const StateEstimate& estimate, GuidanceOutput& output) {
    if (!hold_) {
      hold_.emplace();
      hold_->position_m = estimate.T_local_body.translation();
      hold_->yaw_rad = yaw_of(estimate.T_local_body.linear());
    }
    hold_->yaw_rad = std::remainder(hold_->yaw_rad + kTurn_radps * dt_s, 2.0 * kPi);
    hold_->yaw_rate_radps = kTurn_radps;
    output = {};
    output.goal = *hold_;
    output.note = "looks for itself in the map of an earlier flight";
  }

 private:
  static constexpr double kTurn_radps = 0.4;
  std::optional<Reference> hold_;  // in the local frame
};

}  // namespace swiftlet
