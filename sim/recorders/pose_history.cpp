// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/pose_history.hpp"

#include <algorithm>

namespace swiftlet::sim {
namespace {

// [ns] Age up to which poses are kept: longer than any sweep plus its latency. Larger values cost memory.
constexpr TimeNs kKept = 2 * kNsPerSecond;

}  // namespace

void PoseHistory::push(TimeNs t, const Pose& T_world_body) {
  if (!poses_.empty() && t <= poses_.back().t) return;
  poses_.push_back({t, T_world_body});
  while (poses_.front().t < t - kKept) poses_.pop_front();
}

Pose PoseHistory::at(TimeNs t) const {
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), t,
                                      [](const StampedPose& pose, TimeNs time) { return pose.t < time; });
  if (after == poses_.begin()) return poses_.front().T_world_body;
  if (after == poses_.end()) return poses_.back().T_world_body;
  const StampedPose& a = *(after - 1);
  const StampedPose& b = *after;
  const double s = static_cast<double>(t - a.t) / static_cast<double>(b.t - a.t);
  const Vector3 position = (1 - s) * a.T_world_body.translation() + s * b.T_world_body.translation();
  const Eigen::Quaterniond q_a(a.T_world_body.linear());
  return make_pose(position, q_a.slerp(s, Eigen::Quaterniond(b.T_world_body.linear())));
}

}  // namespace swiftlet::sim
