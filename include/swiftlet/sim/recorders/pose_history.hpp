// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet::sim {

/// The estimated poses of the last seconds, to look up the estimated pose during a sweep.
class PoseHistory {
 public:
  /// Poses must be in order of time; one that is not newer than the last is ignored.
  void push(TimeNs t, const Pose& T_world_body);
  bool empty() const { return poses_.empty(); }
  /// Linear in position, slerp in attitude; clamped to the oldest and newest stored pose. Requires a nonempty history.
  Pose at(TimeNs t) const;

 private:
  std::deque<StampedPose> poses_;
};

}  // namespace swiftlet::sim
