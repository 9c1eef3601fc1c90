// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/path_follower.hpp"

#include <algorithm>

#include "swiftlet/core/ensure.hpp"

namespace swiftlet {
namespace {

constexpr double kArrived_m = 0.3;

/// Of the segment from a to b.
Vector3 nearest_on(const Vector3& a_m, const Vector3& b_m, const Vector3& p_m) {
  const Vector3 way_m = b_m - a_m;
  const double share = way_m.dot(p_m - a_m) / std::max(way_m.squaredNorm(), 1e-12);
  return a_m + std::clamp(share, 0.0, 1.0) * way_m;
}

}  // namespace

void PathFollower::start(std::vector<Vector3> corners_local_m) {
  ENSURE(corners_local_m.size() >= 2, corners_local_m.size());
  corners_local_m_ = std::move(corners_local_m);
  next_ = 1;
  checked_ = 0;
}

PathFollower::Outcome PathFollower::step(const GuidanceInput& input) {
  const Vector3 p_local_m = input.estimate.T_local_body.translation();
  if (is_blocked(*input.map, p_local_m)) {
    target_local_m_ = p_local_m;
    return Outcome::kBlocked;
  }
  target_local_m_ = corners_local_m_[next_];
  const double distance_m = (p_local_m - target_local_m_).norm();
  const bool last = next_ + 1 == corners_local_m_.size();
  if (!last && distance_m < visited_m_) ++next_;
  const bool arrived = last && distance_m < kArrived_m && input.estimate.v_local_mps.norm() < kHovers_mps;
  return arrived ? Outcome::kArrived : Outcome::kFlying;
}

/// Has the map changed so that the rest of the path is not clear any more?
bool PathFollower::is_blocked(const OccupancyView& map, const Vector3& p_local_m) {
  if (checked_ == map.revision()) return false;
  checked_ = map.revision();
  // A cell's edge less than it was planned with: an obstacle whose cells flicker makes no other path.
  ClearPathConfig rules = rules_;
  rules.clearance_m = std::max(rules.clearance_m - map.edge_m(), 0.5 * map.edge_m());
  const ClearSpace space(map, rules, p_local_m);
  Vector3 from_local_m = nearest_on(corners_local_m_[next_ - 1], corners_local_m_[next_], p_local_m);
  for (std::size_t i = next_; i < corners_local_m_.size(); ++i) {
    if (!space.is_clear_segment(from_local_m, corners_local_m_[i])) return true;
    from_local_m = corners_local_m_[i];
  }
  return false;
}

}  // namespace swiftlet
