// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "core/guidance/half_space.hpp"
#include "swiftlet/core/control/reference_governor.hpp"

namespace swiftlet {

/// A reference that can stop at any time without crossing the given planes.
///
/// Turning while braking reduces the deceleration, so a goal behind the planes does not guarantee a stop behind them.
/// Each period is simulated in advance, with braking at its end. When the simulated motion crosses a plane, the goal is
/// moved toward the stopping point of braking now. When no such goal is admissible, the vehicle brakes.
class GuardedReference {
 public:
  /// @param planar  all planes are vertical, so the vehicle continues to the goal's height while it brakes
  explicit GuardedReference(const MotionLimits& limits, bool planar = false) : governor_(limits), planar_(planar) {}

  void reset(const Reference& start);

  /// Stopping point when braking begins now.
  Vector3 rest_local_m() const;

  /// Admissible goal of the next period; the commanded goal moves linearly to it from the last one.
  /// @param planes  relative to `p_local_m`, the estimated position of the vehicle
  Vector3 admit(const Vector3& last_goal_local_m, const Vector3& goal_local_m, std::span<const HalfSpace> planes,
                const Vector3& p_local_m, double period_s, double speed_limit_mps);

  /// Advances the reference by one tick.
  const Reference& step(const Reference& goal, double dt_s, double speed_limit_mps);

 private:
  Vector3 rest_after_local_m(const Vector3& last_goal_local_m, const Vector3& goal_local_m, double period_s,
                             double speed_limit_mps) const;

  ReferenceGovernor governor_;
  bool planar_;
  bool braking_ = false;
};

}  // namespace swiftlet
