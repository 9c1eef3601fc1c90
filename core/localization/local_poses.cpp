// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/local_poses.hpp"

#include <algorithm>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {

Pose interpolate(const TimedPose& before, const TimedPose& after, TimeNs t) {
  if (t <= before.t) return before.T;
  if (t >= after.t) return after.T;
  const double f = static_cast<double>(t - before.t) / static_cast<double>(after.t - before.t);
  const Eigen::Quaterniond q0(before.T.linear()), q1(after.T.linear());
  const Vector3 p0 = before.T.translation(), p1 = after.T.translation();
  return make_pose(p0 + f * (p1 - p0), q0.slerp(f, q1));
}

void LocalPoses::push(const StateEstimate& estimate) {
  if (!estimate.valid || !estimate.T_local_body.matrix().allFinite()) return;
  if (count_ > 0 && estimate.t <= (*this)[count_ - 1].t) return;
  if (count_ < kCapacity)
    ++count_;
  else
    first_ = (first_ + 1) % kCapacity;
  ring_[(first_ + count_ - 1) % kCapacity] = {estimate.t, estimate.T_local_body};
}

Pose LocalPoses::at(TimeNs t) const {
  ENSURE(count_ > 0, t);
  int after = 0, end = count_;  // index of the first pose later than t
  while (after < end) {
    const int middle = (after + end) / 2;
    if ((*this)[middle].t <= t)
      after = middle + 1;
    else
      end = middle;
  }
  return interpolate((*this)[std::max(after - 1, 0)], (*this)[std::min(after, count_ - 1)], t);
}

}  // namespace swiftlet
