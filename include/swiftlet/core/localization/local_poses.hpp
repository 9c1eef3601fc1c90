// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "swiftlet/core/state_estimate.hpp"

namespace swiftlet {

/// A pose in whatever frame its holder names.
struct TimedPose {
  TimeNs t = 0;
  Pose T = Pose::Identity();
};

/// The pose at time t between two others; position linear, rotation along the shortest arc. Outside: the nearer one.
Pose interpolate(const TimedPose& before, const TimedPose& after, TimeNs t);

/// Where the vehicle was in its local frame during the last two seconds: the estimates of the last 512 ticks.
class LocalPoses {
 public:
  /// Every estimate, in order of time. Those that are not valid are passed over.
  void push(const StateEstimate& estimate);
  /// Of the body at time t: interpolated, or the nearest known. Not before the first push.
  Pose at(TimeNs t) const;
  int size() const { return count_; }
  /// From the oldest on.
  const TimedPose& operator[](int i) const { return ring_[(first_ + i) % kCapacity]; }

 private:
  static constexpr int kCapacity = 512;
  std::array<TimedPose, kCapacity> ring_{};
  int first_ = 0;
  int count_ = 0;
};

}  // namespace swiftlet
