// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/control/motion_limits.hpp"

namespace swiftlet {

/// Limits the goal from guidance to a feasible reference. Its position follows the goal within the limits of velocity,
/// acceleration and jerk, and its heading within those of rate and acceleration.
///
/// A distant goal is approached in nearly minimum time along straight lines. A moving goal that keeps the limits is
/// followed without lag, sample by sample.
///
/// The limits hold by construction for any goal: from every reachable state, braking at full jerk ends the acceleration
/// before the speed limit is reached. That braking step is always available.
class ReferenceGovernor {
 public:
  explicit ReferenceGovernor(const MotionLimits& limits);

  /// Resets the state to `start`; velocity is clipped to the limits, acceleration and heading rate start from zero.
  void reset(const Reference& start);

  /// One step of `dt_s` toward `goal`, the reference at the end of the step. A goal that is not finite is replaced by
  /// the last one.
  /// @param speed_limit_mps  current lower speed limit from guidance; approached without violating the other limits
  const Reference& step(const Reference& goal, double dt_s,
                        double speed_limit_mps = std::numeric_limits<double>::infinity());

  /// Adopts a reference that keeps the limits without change; step() continues from it. References that are not finite
  /// are ignored.
  const Reference& take(const Reference& feasible, double dt_s);

  /// One step with the wanted acceleration, clipped to the limits. At the speed limit it still changes direction.
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
