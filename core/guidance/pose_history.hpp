// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>

#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// The vehicle's own last poses: what a sensor saw some time ago was seen from there.
class PoseHistory {
 public:
  void push(TimeNs t, const Pose& T_world_body) {
    if (count_ > 0 && t <= at_index(count_ - 1).t) return;
    slots_[(first_ + count_) % kCapacity] = {t, T_world_body};
    if (count_ < kCapacity) {
      ++count_;
    } else {
      first_ = (first_ + 1) % kCapacity;
    }
  }

  bool empty() const { return count_ == 0; }

  /// Interpolated between the two around `t`; the oldest or newest one outside of them. Not of an empty history.
  Pose at(TimeNs t) const {
    int low = 0, high = count_ - 1;
    if (t <= at_index(low).t) return at_index(low).T_world_body;
    if (t >= at_index(high).t) return at_index(high).T_world_body;
    while (high - low > 1) {
      const int middle = (low + high) / 2;
      (at_index(middle).t <= t ? low : high) = middle;
    }
    const StampedPose& a = at_index(low);
    const StampedPose& b = at_index(high);
    const double s = to_seconds(t - a.t) / to_seconds(b.t - a.t);
    const Eigen::Quaterniond q_a(a.T_world_body.linear()), q_b(b.T_world_body.linear());
    return make_pose((1.0 - s) * a.T_world_body.translation() + s * b.T_world_body.translation(), q_a.slerp(s, q_b));
  }

 private:
  static constexpr int kCapacity = 256;  // about a second at 250 Hz
  const StampedPose& at_index(int i) const { return slots_[(first_ + i) % kCapacity]; }

  std::array<StampedPose, kCapacity> slots_{};
  int first_ = 0, count_ = 0;
};

}  // namespace swiftlet
