// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/guiding/guided_path.hpp"

#include <algorithm>
#include <cmath>

#include "core/guidance/guiding/guide_constants.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {

void GuidedPath::drop_visited(const Vector3& p_local_m, double visited_m) {
  while (poses_.size() > 1 && (poses_.front().p_local_m - p_local_m).norm() < visited_m) poses_.erase(poses_.begin());
}

bool GuidedPath::is_reached_from(const Vector3& p_local_m, double tolerance_m) const {
  return poses_.size() == 1 && (poses_.back().p_local_m - p_local_m).norm() < tolerance_m;
}

double GuidedPath::length_from_m(const Vector3& p_local_m) const {
  double left_m = (poses_.front().p_local_m - p_local_m).norm();
  for (std::size_t i = 1; i < poses_.size(); ++i) left_m += (poses_[i].p_local_m - poses_[i - 1].p_local_m).norm();
  return left_m;
}

bool GuidedPath::is_blocked(const OccupancyView& map, const ClearPathConfig& rules, const RelativeEstimate& estimate,
                            TimeNs now) const {
  double skipped_m = rules.clearance_m + GuideConstants::kOwnCells_m +
                     estimate.velocity_mps.norm() * to_seconds(now - estimate.report_t);
  std::vector<Vector3> corners_local_m = {estimate.position_m};
  for (const PlannedPose& pose : poses_) {
    const Vector3 leg_m = pose.p_local_m - corners_local_m.back();
    if (skipped_m > 0.0) {
      const double share = std::min(1.0, skipped_m / leg_m.norm());
      corners_local_m.back() += share * leg_m;
      skipped_m -= leg_m.norm();
    }
    if (skipped_m <= 0.0) corners_local_m.push_back(pose.p_local_m);
  }
  return corners_local_m.size() > 1 && swiftlet::is_blocked(map, rules, estimate.position_m, corners_local_m);
}

std::size_t GuidedPath::num_in_sight(const OccupancyView& map, const Vector3& p_local_m, double range_m) const {
  const auto hidden = std::ranges::find_if(poses_, [&](const PlannedPose& pose) {
    return (pose.p_local_m - p_local_m).head<2>().norm() > range_m || map.first_hit(p_local_m, pose.p_local_m);
  });
  return static_cast<std::size_t>(hidden - poses_.begin());
}

void GuidedPath::append_to(GuidingPath& report, std::size_t num_poses, const RelativeEstimate& estimate) const {
  report.has_instant = true;
  report.t = estimate.report_stamp;
  const double yaw_rad = estimate.report_yaw_rad;
  const double s = elementary::sin(yaw_rad), c = elementary::cos(yaw_rad);
  report.waypoints.reserve(num_poses);
  for (const PlannedPose& pose : std::span(poses_).first(num_poses)) {
    const Vector3 d_m = pose.p_local_m - estimate.report_position_m;
    GuidingWaypoint& waypoint = report.waypoints.emplace_back();
    waypoint.p_body_m = Vector3(c * d_m.x() + s * d_m.y(), c * d_m.y() - s * d_m.x(), d_m.z()).cast<float>();
    waypoint.yaw_rad = static_cast<float>(std::remainder(pose.yaw_rad - yaw_rad, 2.0 * kPi));
  }
}

}  // namespace swiftlet
