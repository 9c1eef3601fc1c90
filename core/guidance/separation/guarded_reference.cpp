// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/separation/guarded_reference.hpp"

#include <algorithm>

#include "core/guidance/guidance_constants.hpp"

namespace swiftlet {
namespace {

/// [s] Step of the simulated braking. Larger values cost less, and misjudge the stopping point by more.
constexpr double kStep_s = 0.05;
/// [-] Steps of the simulated period, in which the goal moves. More steps cost time and follow the goal more closely.
constexpr int kParts = 4;
/// [steps] Longest simulated braking: 20 s, within which every vehicle is at rest.
constexpr int kMaxSteps = 400;
/// [1/s] Deceleration per speed near rest. Larger values stop later and harder.
constexpr double kBrakingPole_radps = 5.0;

void brake(ReferenceGovernor& governor, double yaw_rad, double dt_s) {
  governor.accelerate(-kBrakingPole_radps * governor.state().velocity_mps, yaw_rad, dt_s);
}

Vector3 rest_of(ReferenceGovernor governor) {
  for (int i = 0; i < kMaxSteps && governor.state().velocity_mps.norm() > kAtRest_mps; ++i) {
    brake(governor, governor.state().yaw_rad, kStep_s);
  }
  return governor.state().position_m;
}

}  // namespace

void GuardedReference::reset(const Reference& start) {
  governor_.reset(start);
  braking_ = false;
}

Vector3 GuardedReference::rest_local_m() const { return rest_of(governor_); }

Vector3 GuardedReference::rest_after_local_m(const Vector3& last_goal_local_m, const Vector3& goal_local_m,
                                             double period_s, double speed_limit_mps) const {
  ReferenceGovernor ahead = governor_;
  Reference goal;
  goal.yaw_rad = governor_.state().yaw_rad;
  for (int i = 1; i <= kParts; ++i) {
    const double share = static_cast<double>(i) / kParts;
    goal.position_m = (1.0 - share) * last_goal_local_m + share * goal_local_m;
    ahead.step(goal, period_s / kParts, speed_limit_mps);
  }
  return rest_of(ahead);
}

Vector3 GuardedReference::admit(const Vector3& last_goal_local_m, const Vector3& goal_local_m,
                                std::span<const HalfSpace> planes, const Vector3& p_local_m, double period_s,
                                double speed_limit_mps) {
  braking_ = false;
  if (planes.empty()) return goal_local_m;
  const Vector3 rest_m = rest_local_m();
  const auto crosses = [&](const Vector3& q_m) {
    return std::any_of(planes.begin(), planes.end(), [&](const HalfSpace& plane) {
      // A plane that braking now, or staying, violates is relaxed by that violation: no goal can do better.
      const double least_m = std::max(0.0, plane.normal_local.dot(rest_m - p_local_m));
      return plane.normal_local.dot(q_m - p_local_m) > std::max(plane.offset_m, least_m) + kOnPlane_m;
    });
  };
  for (const Vector3& wanted_local_m : {goal_local_m, rest_m}) {
    if (!crosses(rest_after_local_m(last_goal_local_m, wanted_local_m, period_s, speed_limit_mps)))
      return wanted_local_m;
  }
  braking_ = true;
  return rest_m;
}

const Reference& GuardedReference::step(const Reference& goal, double dt_s, double speed_limit_mps) {
  if (!braking_) return governor_.step(goal, dt_s, speed_limit_mps);
  const Reference& now = governor_.state();
  Vector3 a_mps2 = -kBrakingPole_radps * now.velocity_mps;
  if (planar_) {  // critically damped
    a_mps2.z() += 0.25 * kBrakingPole_radps * kBrakingPole_radps * (goal.position_m.z() - now.position_m.z());
  }
  governor_.accelerate(a_mps2, goal.yaw_rad, dt_s);
  return governor_.state();
}

}  // namespace swiftlet
