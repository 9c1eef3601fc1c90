// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "swiftlet/core/base/state_estimate.hpp"

namespace swiftlet {

/// A stamped pose; the frame is defined by the user.
struct TimedPose {
  TimeNs t = 0;
  Pose T = Pose::Identity();
};

/// Pose at time t between two others; position linear, rotation along the shortest arc. Outside: the nearer one.
Pose interpolate(const TimedPose& before, const TimedPose& after, TimeNs t);

/// Poses of the vehicle in its local frame during the last two seconds: the estimates of the last 512 ticks.
class LocalPoses {
 public:
  /// Adds an estimate, in order of time. Invalid estimates are ignored.
  void push(const StateEstimate& estimate);
  /// Body pose at time t: interpolated, or the nearest known. Requires a previous push.
  Pose at(TimeNs t) const;
  int size() const { return count_; }
  /// Poses in order of time, from the oldest.
  const TimedPose& operator[](int i) const { return ring_[(first_ + i) % kCapacity]; }

 private:
  /// [-] Stored poses, one per tick. Must cover a sweep and its latency.
  static constexpr int kCapacity = 512;
  std::array<TimedPose, kCapacity> ring_{};
  int first_ = 0;
  int count_ = 0;
};

}  // namespace swiftlet
