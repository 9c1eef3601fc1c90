// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/control/motion_limits.hpp"

namespace swiftlet {

/// Makes whatever guidance asks for flyable. Its point follows the goal within the limits of velocity, acceleration and
/// jerk, and its heading within those of rate and acceleration.
///
/// A goal far away is approached in nearly least time along straight lines. A moving goal that keeps the limits itself
/// is followed without lag, sample by sample.
///
/// The limits hold by construction, whatever the goal. From every state that it enters, braking at full jerk ends the
/// acceleration before the speed limit is reached. That braking step is always at hand.
class ReferenceGovernor {
 public:
  explicit ReferenceGovernor(const MotionLimits& limits);

  /// Starts here; velocity is cut to the limits, acceleration and turning start from zero.
  void reset(const Reference& start);

  /// One step of `dt_s` toward `goal`, which is where to be at the end of the step. Not-finite goals keep the last one.
  /// @param speed_limit_mps  a lower speed that guidance wishes for now; approached without breaking the other limits
  const Reference& step(const Reference& goal, double dt_s,
                        double speed_limit_mps = std::numeric_limits<double>::infinity());

  /// A reference that keeps the limits by itself is taken as it is; step() goes on from there. Not-finite ones are not.
  const Reference& take(const Reference& feasible, double dt_s);

  /// One step with the acceleration that is wanted, as far as the limits allow. At the speed limit it still turns.
  const Reference& accelerate(const Vector3& a_local_mps2, double yaw_rad, double dt_s);

  const Reference& state() const { return state_; }
  const Vector3& jerk_mps3() const { return jerk_mps3_; }
  const MotionLimits& limits() const { return limits_; }

 private:
  void step_once(const Reference& goal, double dt_s, double speed_limit_mps);

  MotionLimits limits_;
  Reference state_;
  Reference last_goal_;
  Vector3 jerk_mps3_ = Vector3::Zero();
};

}  // namespace swiftlet
