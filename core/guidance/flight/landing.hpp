// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// Descends at constant speed until the vehicle stands on the ground, which is detected by the growing distance to the
/// descending goal. Needs no measured height.
class Landing {
 public:
  explicit Landing(double speed_mps) : speed_mps_(speed_mps) {}

  void start(const Vector3& position_local_m, double yaw_rad);
  bool started() const { return started_; }
  /// Writes the goal for this tick; true once on the ground.
  bool step(const StateEstimate& estimate, double dt_s, Reference& goal);
  /// Ends a mission: lands below `from`, then stops the motors. True once on the ground.
  bool finish(const Reference& from, const GuidanceInput& input, GuidanceOutput& output);

 private:
  double speed_mps_;
  bool started_ = false;
  Reference goal_;
  double still_s_ = 0.0;  ///< time for which the vehicle has stood on the ground
};

}  // namespace swiftlet
