// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {

/// Return of a vehicle that is about to lose its position: it flies back along its own path until its sensors see
/// enough again, and hovers there.
class WayBack {
 public:
  /// @param output  that of guidance in the last tick; written when the return takes over, which is the result
  bool takes_over(const StateEstimate& estimate, bool should_return, GuidanceOutput& output) {
    const bool flies_mission = output.motors_on && output.mission == MissionStatus::kRunning;
    if (!hold_ && !(should_return && flies_mission)) {
      add(estimate.T_local_body.translation());
      return false;
    }
    step(estimate, !should_return, output);
    return true;
  }

 private:
  /// [m] Distance between stored positions, and distance at which one counts as reached. Larger values return faster
  /// and cut corners.
  static constexpr double kSpacing_m = 0.5, kReached_m = 1.0;
  /// [-] Number of stored positions: 200 m of path.
  static constexpr int kCapacity = 400;

  void add(const Vector3& p_local_m) {
    if (count_ > 0 && (p_local_m - newest()).norm() < kSpacing_m) return;
    path_local_m_[(first_ + count_) % kCapacity] = p_local_m;
    if (count_ < kCapacity)
      ++count_;
    else
      first_ = (first_ + 1) % kCapacity;
  }

  void step(const StateEstimate& estimate, bool sees_enough, GuidanceOutput& output) {
    const Vector3 p_local_m = estimate.T_local_body.translation();
    if (!hold_) {
      hold_.emplace();
      hold_->position_m = p_local_m;
      hold_->yaw_rad = yaw_of(estimate.T_local_body.linear());
    }
    if (!has_returned_ && (sees_enough || (hold_->position_m - p_local_m).norm() < kReached_m)) {
      has_returned_ = sees_enough || count_ == 0;
      if (!has_returned_) hold_->position_m = path_local_m_[(first_ + --count_) % kCapacity];
    }
    output = {};
    output.goal = *hold_;
    output.mission = has_returned_ ? MissionStatus::kFailed : MissionStatus::kRunning;
    output.note = has_returned_ ? "returned: too little to see ahead" : "returning: too little to see ahead";
  }

  const Vector3& newest() const { return path_local_m_[(first_ + count_ - 1) % kCapacity]; }

  std::array<Vector3, kCapacity> path_local_m_;
  int first_ = 0, count_ = 0;
  std::optional<Reference> hold_;  // in the local frame
  bool has_returned_ = false;
};

}  // namespace swiftlet
