// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_viewed.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [-] Number of remembered views: about 100 m of flight. Larger values remember longer and cost time in contains().
constexpr std::size_t kLooks = 256;
/// [m], [rad] Displacement or turn after which a view is added. Smaller values shorten the remembered flight.
constexpr double kMoved_m = 0.4, kTurned_rad = 0.2;

}  // namespace

RblViewed::RblViewed(double reach_m, double own_half_m) : reach_m_(reach_m), own_half_m_(own_half_m) {
  looks_.reserve(kLooks);
}

void RblViewed::look(const Vector3& p_local_m, double yaw_rad, const std::array<HalfSpace, 2>& view) {
  if (!looks_.empty()) {
    const Look& last = looks_[(next_ + looks_.size() - 1) % looks_.size()];
    const double turned_rad = std::abs(std::remainder(yaw_rad - last.yaw_rad, 2.0 * kPi));
    if ((p_local_m - last.p_local_m).norm() < kMoved_m && turned_rad < kTurned_rad) return;
  }
  if (looks_.size() < kLooks) {
    looks_.push_back({p_local_m, yaw_rad, view});
    return;
  }
  looks_[next_] = {p_local_m, yaw_rad, view};
  next_ = (next_ + 1) % kLooks;
}

bool RblViewed::contains(const Vector3& q_local_m, const OccupancyView& map) const {
  return std::any_of(looks_.begin(), looks_.end(), [&](const Look& look) {
    const Vector3 to_m = q_local_m - look.p_local_m;
    const double d = to_m.norm();
    if (d <= own_half_m_) return true;
    if (d > reach_m_) return false;
    const bool in_view = std::all_of(look.view.begin(), look.view.end(), [&](const HalfSpace& side) {
      return side.normal_local.dot(to_m) <= side.offset_m;
    });
    return in_view && !map.first_hit(look.p_local_m, q_local_m);
  });
}

}  // namespace swiftlet
