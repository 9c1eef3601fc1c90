// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flight/landing.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

/// [m] greatest distance of the goal below the vehicle. Bounds the thrust downwards on the ground.
constexpr double kGoalBelowMax_m = 0.5;
/// [m] distance of the goal below the vehicle from which the ground may hold the vehicle up. Below kGoalBelowMax_m;
/// smaller values take a vehicle that lags behind its goal for one on the ground.
constexpr double kGoalBelowLanded_m = 0.3;
/// [m/s] vertical speed below which the vehicle counts as held up. Smaller values may miss a landing with noisy
/// estimates.
constexpr double kHeldUp_mps = 0.1;
/// [s] time for which the vehicle is held up before it counts as landed. Smaller values may stop the motors in the air.
constexpr double kHeldUp_s = 0.5;

}  // namespace

void Landing::start(const Vector3& position_local_m, double yaw_rad) {
  started_ = true;
  still_s_ = 0.0;
  goal_ = {};
  goal_.position_m = position_local_m;
  goal_.yaw_rad = yaw_rad;
}

bool Landing::step(const StateEstimate& estimate, double dt_s, Reference& goal) {
  const double z_m = estimate.T_local_body.translation().z();
  goal_.position_m.z() -= speed_mps_ * dt_s;
  goal_.velocity_mps.z() = -speed_mps_;
  if (goal_.position_m.z() < z_m - kGoalBelowMax_m) {
    goal_.position_m.z() = z_m - kGoalBelowMax_m;
    goal_.velocity_mps.z() = 0.0;
  }
  goal = goal_;

  const bool held_up = z_m - goal_.position_m.z() > kGoalBelowLanded_m &&
                       std::abs(estimate.v_local_mps.z()) < std::min(kHeldUp_mps, 0.5 * speed_mps_);
  still_s_ = held_up ? still_s_ + dt_s : 0.0;
  return still_s_ >= kHeldUp_s;
}

bool Landing::finish(const Reference& from, const GuidanceInput& input, GuidanceOutput& output) {
  if (!started_) start(from.position_m, from.yaw_rad);
  const bool landed = step(input.estimate, input.dt_s, output.goal);
  output.note = landed ? "landed" : "landing";
  if (landed) {
    output.motors_on = false;
    output.mission = MissionStatus::kDone;
  }
  return landed;
}

}  // namespace swiftlet
