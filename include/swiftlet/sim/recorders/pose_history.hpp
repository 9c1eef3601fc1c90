// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet::sim {

/// Recent estimated poses of a vehicle, interpolated at the times of the beams of a sweep.
class PoseHistory {
 public:
  /// Adds the newest pose. Ignored when its time is not later than that of the previous one.
  void push(TimeNs t, const Pose& T_world_body);
  bool empty() const { return poses_.empty(); }
  /// Interpolates linearly in position and by slerp in attitude. Times beyond the stored ones give the oldest or newest
  /// pose. Requires a nonempty history.
  Pose at(TimeNs t) const;

 private:
  std::deque<StampedPose> poses_;
};

}  // namespace swiftlet::sim
