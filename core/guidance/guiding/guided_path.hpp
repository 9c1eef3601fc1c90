// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "swiftlet/core/base/relative_estimate.hpp"
#include "swiftlet/core/messages/guiding_path.hpp"
#include "swiftlet/core/planning/team_plan.hpp"

namespace swiftlet {

/// Remaining path of the guided vehicle, in the local frame of the guide.
class GuidedPath {
 public:
  bool empty() const { return poses_.empty(); }
  std::span<const PlannedPose> poses() const { return poses_; }
  void clear() { poses_.clear(); }
  /// Appends the guided vehicle's path of a plan, without the start pose.
  void append(const TeamPlan& plan) {
    poses_.insert(poses_.end(), plan.secondary_path.begin() + 1, plan.secondary_path.end());
  }
  /// Removes poses from the beginning while they are nearer than `visited_m` to the position; the last one is kept.
  void drop_visited(const Vector3& p_local_m, double visited_m);
  /// True when only the last pose is left and within the tolerance of the position.
  bool is_reached_from(const Vector3& p_local_m, double tolerance_m) const;
  /// Length of the path from the position through all poses. Requires a pose.
  double length_from_m(const Vector3& p_local_m) const;
  /// True when obstacles lie on the path. The check skips the beginning of the path, where occupied cells may be the
  /// guided vehicle itself: the vehicle has moved since its last report.
  bool is_blocked(const OccupancyView& map, const ClearPathConfig& rules, const RelativeEstimate& estimate,
                  TimeNs now) const;
  /// Number of leading poses that are within range and in line of sight of a position.
  /// @param range_m  greatest horizontal distance
  std::size_t num_in_sight(const OccupancyView& map, const Vector3& p_local_m, double range_m) const;
  /// Appends the first `num_poses` poses. Their frame is the guided vehicle's level body frame at the time of its
  /// newest odometry report, so that the radio's delay does not shift the path.
  void append_to(GuidingPath& report, std::size_t num_poses, const RelativeEstimate& estimate) const;

 private:
  std::vector<PlannedPose> poses_;
};

}  // namespace swiftlet
