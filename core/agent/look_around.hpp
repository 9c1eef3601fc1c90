// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/localization/estimator.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {

/// Motion of a vehicle that is not localized yet: it holds its position and turns, so that its LiDAR sees all around.
/// When the search has failed, it holds its pose.
class LookAround {
 public:
  void step(double dt_s, const StateEstimate& estimate, StateEstimator::Search search, GuidanceOutput& output) {
    if (!hold_) {
      hold_.emplace();
      hold_->position_m = estimate.T_local_body.translation();
      hold_->yaw_rad = yaw_of(estimate.T_local_body.linear());
    }
    const bool is_searching = search == StateEstimator::Search::kActive;
    hold_->yaw_rate_radps = is_searching ? kTurn_radps : 0.0;
    hold_->yaw_rad = std::remainder(hold_->yaw_rad + hold_->yaw_rate_radps * dt_s, 2.0 * kPi);
    output = {};
    output.goal = *hold_;
    output.mission = is_searching ? MissionStatus::kRunning : MissionStatus::kFailed;
    output.note = is_searching ? "localizing in the saved map" : "localization in the saved map failed";
  }

 private:
  /// [rad/s] Rate of the turn. Larger values see all around sooner, with fewer scans of each direction.
  static constexpr double kTurn_radps = 0.4;
  std::optional<Reference> hold_;  // in the local frame
};

}  // namespace swiftlet
