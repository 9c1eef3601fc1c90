// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "core/guidance/flight/path_follower.hpp"
#include "swiftlet/core/planning/team_plan.hpp"

namespace swiftlet {

/// Flight of the guide to its viewpoint, from corner to corner of its path.
class ViewpointFlight {
 public:
  /// @param config  must outlive this object
  explicit ViewpointFlight(const TeamPlannerConfig& config) : config_(config) {}

  /// @param corners_local_m  empty: the guide is at its viewpoint
  void start(std::vector<Vector3> corners_local_m) {
    corners_local_m_ = std::move(corners_local_m);
    next_ = 1;
  }
  /// Sets the next position. True when the guide hovers at its viewpoint.
  bool step(const StateEstimate& estimate, Vector3& target_local_m) {
    if (corners_local_m_.empty()) return true;
    target_local_m = corners_local_m_[next()];
    if ((estimate.T_local_body.translation() - target_local_m).norm() >= config_.tolerance_m) return false;
    const bool last = next_ + 1 >= corners_local_m_.size();
    if (!last) ++next_;
    return last && estimate.v_local_mps.norm() < PathFollower::kHovers_mps;
  }
  bool is_away(const Vector3& p_local_m) const {
    return !corners_local_m_.empty() && (corners_local_m_.back() - p_local_m).norm() >= config_.tolerance_m;
  }
  /// The path may lead through space that was unknown when it was planned.
  bool is_blocked(const OccupancyView& map, const Vector3& p_local_m) const {
    return corners_local_m_.size() > 1 &&
           swiftlet::is_blocked(map, config_.primary, p_local_m, corners_local_m_, next());
  }

 private:
  std::size_t next() const { return std::min(next_, corners_local_m_.size() - 1); }

  const TeamPlannerConfig& config_;
  std::vector<Vector3> corners_local_m_;
  std::size_t next_ = 1;  // index of the next corner
};

}  // namespace swiftlet
