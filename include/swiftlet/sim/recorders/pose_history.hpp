// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>

#include "swiftlet/core/frames.hpp"

namespace swiftlet::sim {

/// The poses of the last seconds, to look up where a vehicle believed to be during a sweep.
class PoseHistory {
 public:
  /// Poses come in order of time; one that is not newer than the last is ignored.
  void push(TimeNs t, const Pose& T_world_body);
  bool empty() const { return poses_.empty(); }
  /// Linear in position, slerp in attitude; before the oldest kept one or after the newest: that one. Not when empty.
  Pose at(TimeNs t) const;

 private:
  std::deque<StampedPose> poses_;
};

}  // namespace swiftlet::sim
