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
  /// Appends the path of a plan without its start.
  void append(const TeamPlan& plan) {
    poses_.insert(poses_.end(), plan.secondary_path.begin() + 1, plan.secondary_path.end());
  }
  /// Keeps at least the last pose.
  void drop_visited(const Vector3& p_local_m, double visited_m);
  bool is_reached_from(const Vector3& p_local_m, double tolerance_m) const;
  double length_from_m(const Vector3& p_local_m) const;
  /// True when obstacles lie on the path. Its beginning is skipped: cells there may be the guided vehicle itself, which
  /// has moved since its last report.
  bool is_blocked(const OccupancyView& map, const ClearPathConfig& rules, const RelativeEstimate& estimate,
                  TimeNs now) const;
  /// Number of poses in sight of a position, from the first one on.
  /// @param range_m  greatest horizontal distance
  std::size_t num_in_sight(const OccupancyView& map, const Vector3& p_local_m, double range_m) const;
  /// Appends the first poses in the vehicle's level body frame at the time of its newest odometry, so that the radio's
  /// delay does not shift the path.
  void append_to(GuidingPath& report, std::size_t num_poses, const RelativeEstimate& estimate) const;

 private:
  std::vector<PlannedPose> poses_;
};

}  // namespace swiftlet
