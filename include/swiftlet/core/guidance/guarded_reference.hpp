// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "swiftlet/core/control/reference_governor.hpp"
#include "swiftlet/core/guidance/rbl_cell.hpp"

namespace swiftlet {

/// A reference that can come to rest behind given planes at any time.
///
/// A vehicle that turns aside while it brakes has less to brake with. So a goal behind the planes is not enough. The
/// next period is flown ahead of time, with braking at its end. When that crosses a plane, the goal moves nearer to
/// where the vehicle would come to rest if it braked now. When no goal will do, the vehicle brakes.
class GuardedReference {
 public:
  /// @param planar  no plane is level, so it goes on to the goal's height while it brakes
  explicit GuardedReference(const MotionLimits& limits, bool planar = false) : governor_(limits), planar_(planar) {}

  void reset(const Reference& start);

  /// Where it comes to rest when it brakes at once.
  Vector3 rest_local_m() const;

  /// The goal to fly to in the next period, in which it glides there from the last one.
  /// @param planes  relative to `p_local_m`, the place of the vehicle as far as it knows
  Vector3 admit(const Vector3& last_goal_local_m, const Vector3& goal_local_m, std::span<const HalfSpace> planes,
                const Vector3& p_local_m, double period_s, double speed_limit_mps);

  /// One tick.
  const Reference& step(const Reference& goal, double dt_s, double speed_limit_mps);

 private:
  Vector3 rest_after_local_m(const Vector3& last_goal_local_m, const Vector3& goal_local_m, double period_s,
                             double speed_limit_mps) const;

  ReferenceGovernor governor_;
  bool planar_;
  bool braking_ = false;
};

}  // namespace swiftlet
