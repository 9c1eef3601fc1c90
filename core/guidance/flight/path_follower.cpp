// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flight/path_follower.hpp"

#include <algorithm>

#include "core/guidance/guidance_constants.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

/// [m] distance behind the timed path from which its clock waits. Larger values let the vehicle cut corners.
constexpr double kBehind_m = 0.5;

}  // namespace

void PathFollower::start(std::vector<Vector3> corners_local_m) {
  ENSURE(corners_local_m.size() >= 2, corners_local_m.size());
  corners_local_m_ = std::move(corners_local_m);
  legs_local_m_ = corners_local_m_;
  next_ = 1;
  checked_ = 0;
  timed_ = false;
}

void PathFollower::start(std::vector<Vector3> corners_local_m, SplineTrajectory path_local) {
  start(std::move(corners_local_m));
  spline_local_ = path_local.spline();
  interval_s_ = path_local.interval_s;
  legs_local_m_ = std::move(path_local.control_points_m);
  t_s_ = 0.0;
  timed_ = true;
}

PathFollower::Outcome PathFollower::step(const GuidanceInput& input) {
  const Vector3 p_local_m = input.estimate.T_local_body.translation();
  target_local_ = {};
  if (is_blocked(*input.map, p_local_m)) {
    target_local_.position_m = p_local_m;
    return Outcome::kBlocked;
  }
  const double speed_mps = input.estimate.v_local_mps.norm();
  return timed_ ? step_by_time(p_local_m, speed_mps, input.dt_s) : step_by_corners(p_local_m, speed_mps);
}

PathFollower::Outcome PathFollower::step_by_corners(const Vector3& p_local_m, double speed_mps) {
  target_local_.position_m = legs_local_m_[next_];
  const double distance_m = (p_local_m - target_local_.position_m).norm();
  const bool last = next_ + 1 == legs_local_m_.size();
  if (!last && distance_m < visited_m_) ++next_;
  return last && distance_m < kArrived_m && speed_mps < kHovers_mps ? Outcome::kArrived : Outcome::kFlying;
}

PathFollower::Outcome PathFollower::step_by_time(const Vector3& p_local_m, double speed_mps, double dt_s) {
  if ((p_local_m - spline_local_.at(t_s_).p_m).norm() < kBehind_m) t_s_ += dt_s;
  const auto [p_m, v_mps, a_mps2] = spline_local_.at(t_s_);
  target_local_ = {.position_m = p_m, .velocity_mps = v_mps, .acceleration_mps2 = a_mps2};
  next_ = std::clamp<std::size_t>(static_cast<std::size_t>(t_s_ / interval_s_), 1, legs_local_m_.size() - 1);
  const bool arrived = t_s_ >= spline_local_.duration_s() && (p_local_m - p_m).norm() < kArrived_m;
  return arrived && speed_mps < kHovers_mps ? Outcome::kArrived : Outcome::kFlying;
}

/// True if the map has changed so that the rest of the path is not clear.
bool PathFollower::is_blocked(const OccupancyView& map, const Vector3& p_local_m) {
  if (checked_ == map.revision()) return false;
  checked_ = map.revision();
  return swiftlet::is_blocked(map, rules_, p_local_m, legs_local_m_, next_);
}

}  // namespace swiftlet
