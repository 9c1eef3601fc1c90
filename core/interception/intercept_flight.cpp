// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/intercept_flight.hpp"

#include <algorithm>
#include <cmath>

#include "core/interception/pursuit_laws.hpp"

namespace swiftlet {
namespace {

struct FlightTuning {
  double check_step_s = 0.01;  ///< [s] step of the simulated motion that is checked before it is flown
  /// [m] Limit per axis of the difference between estimate and reference by which the approach is shifted.
  double max_bias_m = 0.5;
  double min_heading_m = 1.0;  ///< [m] shorter horizontal displacements give no heading
  /// [-] Height above the target, in target_clearance_m, from which it is approached directly.
  double direct_above = 0.8;
  /// [-] Lateral offset of an approach from below that height, in target_clearance_m.
  double passing_offset = 1.7;
  double min_side_m = 0.05;     ///< [m] shorter lateral displacements give no side to pass the target
  double same_height_m = 0.05;  ///< [m] within this height difference, a disc keeps its side of the target
  double min_speed_mps = 0.5;   ///< [m/s] slower velocities give no direction to leave a target
  int path_substeps = 5;        ///< [-] steps of the governor between points of a reported path
};
constexpr FlightTuning kFlight;

}  // namespace

InterceptFlight::InterceptFlight(const InterceptConfig& config, const GuidanceSetup& setup)
    : method_(config.method),
      net_(config.net),
      gains_(config.gains),
      target_clearance_m_(config.target_clearance_m),
      period_s_(config.period_s),
      limits_(setup.limits),
      governor_(setup.limits),
      planner_(config.plan, setup.limits, config.plan.reach_share * config.net.radius_m),
      yaw_rad_(yaw_of(setup.agent.T_local_body_start.linear())),
      since_plan_s_(config.period_s) {}

void InterceptFlight::begin_tick(const StateEstimate& estimate) {
  p_local_m_ = estimate.T_local_body.translation();
  if (!started_) {
    started_ = true;
    Reference reference;
    reference.position_m = p_local_m_;
    reference.velocity_mps = estimate.v_local_mps;
    reference.yaw_rad = yaw_of(estimate.T_local_body.linear());
    governor_.reset(reference);
  }
  const Vector3 bias_m = p_local_m_ - governor_.state().position_m;
  bias_local_m_ = bias_m.cwiseMax(-kFlight.max_bias_m).cwiseMin(kFlight.max_bias_m);
}

void InterceptFlight::set_task(const FlightTask& task, bool anew) {
  task_ = task;
  if (!anew) return;
  planner_.forget();
  since_plan_s_ = period_s_;
}

void InterceptFlight::plan() {
  const double since_last_s = since_plan_s_;
  since_plan_s_ = 0.0;
  if (task_.kind == FlightTask::Kind::kChase && method_ == Method::kMpc)
    planner_.plan(state(), *task_.target, to_target_m(*task_.target), side(), *task_.surroundings, since_last_s);
  brakes_ = false;
  ReferenceGovernor tried = governor_;
  const int steps = std::max(1, static_cast<int>(std::ceil(period_s_ / kFlight.check_step_s)));
  for (int i = 0; i < steps; ++i) fly(tried, i * kFlight.check_step_s, i * kFlight.check_step_s, kFlight.check_step_s);
  const double allowed_m = std::max(0.0, task_.surroundings->intrusion_m(governor_.state().position_m, 0.0));
  brakes_ = !can_stop(tried, *task_.surroundings, period_s_, allowed_m);
}

const Reference& InterceptFlight::step(double dt_s) {
  fly(governor_, since_plan_s_, 0.0, dt_s);
  since_plan_s_ += dt_s;
  return governor_.state();
}

PathAhead InterceptFlight::path_ahead() {
  const double yaw_rad = yaw_rad_;
  ReferenceGovernor tried = governor_;
  PathAhead path;
  path.places_local_m[0] = tried.state().position_m + bias_local_m_;
  double ahead_s = 0.0;
  for (path.num_places = 1; path.num_places < PathAhead::kMaxPlaces; ++path.num_places) {
    for (int i = 0; i < kFlight.path_substeps; ++i, ahead_s += path.interval_s / kFlight.path_substeps)
      fly(tried, since_plan_s_ + ahead_s, ahead_s, path.interval_s / kFlight.path_substeps);
    path.places_local_m[static_cast<std::size_t>(path.num_places)] = tried.state().position_m + bias_local_m_;
  }
  yaw_rad_ = yaw_rad;
  return path;
}

/// Moves a reference by one step of the present motion, `since_s` after its plan. Moving obstacles are known as of
/// `ahead_s` ago: simulations look ahead, the flight does not.
void InterceptFlight::fly(ReferenceGovernor& governor, double since_s, double ahead_s, double dt_s) {
  const auto yaw_to_target_rad = [&] { return face(task_.target->at(ahead_s).p_m); };
  if (brakes_) {
    governor.accelerate(braking_mps2(governor.state(), *task_.surroundings, ahead_s, limits_), yaw_rad_, dt_s);
  } else if (task_.kind == FlightTask::Kind::kGoTo) {
    governor.step(goal_of_task(governor.state()), dt_s);
  } else if (task_.kind == FlightTask::Kind::kLeave) {
    governor.accelerate(leave_mps2(governor.state()), yaw_to_target_rad(), dt_s);
  } else if (method_ != Method::kMpc) {
    governor.accelerate(chase_mps2(governor.state(), ahead_s), yaw_to_target_rad(), dt_s);
  } else {
    const PointState planned = planner_.at(since_s + dt_s);
    Reference goal;
    goal.position_m = planned.p_m;
    goal.velocity_mps = planned.v_mps;
    goal.acceleration_mps2 = planned.a_mps2;
    goal.yaw_rad = yaw_to_target_rad();
    governor.step(goal, dt_s);
  }
}

Reference InterceptFlight::goal_of_task(const Reference& self) {
  Reference goal;
  goal.position_m = task_.goal_local_m;
  if (task_.net_to_goal) goal.position_m -= net_.center(Vector3::Zero(), self.yaw_rad);
  goal.position_m = task_.surroundings->fence.inside(goal.position_m);
  goal.yaw_rad = face(goal.position_m);
  return goal;
}

Vector3 InterceptFlight::chase_mps2(const Reference& self, double ahead_s) const {
  const PointState target = task_.target->at(ahead_s);
  const Vector3 net_m = net_.center(self.position_m + bias_local_m_, self.yaw_rad);
  const RelativeMotion relative{target.p_m - net_m, target.v_mps - self.velocity_mps};
  const Vector3 a_mps2 = method_ == Method::kFrpn                     ? frpn_mps2(gains_, relative)
                         : method_ == Method::kProportionalNavigation ? proportional_navigation_mps2(gains_, relative)
                                                                      : pure_pursuit_mps2(gains_, relative);
  return within_acceleration(a_mps2, limits_);
}

/// Leaves a captured target until the net is armed again, along the present motion past it.
Vector3 InterceptFlight::leave_mps2(const Reference& self) const {
  const PointState target = task_.target->at(0.0);
  Vector3 away = self.velocity_mps - target.v_mps;
  if (away.head<2>().norm() < kFlight.min_speed_mps) away = -target.v_mps;
  away.z() = 0.0;
  if (away.norm() < kFlight.min_speed_mps) away = Vector3::UnitX();
  return away.normalized() * limits_.horizontal_acceleration_mps2;
}

double InterceptFlight::arrival_s(const TargetPrediction& target) const {
  return planner_.least_time_s(state(), target, to_target_m(target));
}

/// Displacement from the reference's goal to the target at which the net meets the target.
Vector3 InterceptFlight::to_target_m(const TargetPrediction& target) const {
  const Vector3 offset_m = net_.center(Vector3::Zero(), governor_.state().yaw_rad);
  return offset_m + bias_local_m_ - passing_m(target.at(0.0), offset_m);
}

/// Lateral offset of an approach from below with a net below: the vehicle first flies past the target, not through it.
Vector3 InterceptFlight::passing_m(const PointState& target, const Vector3& offset_local_m) const {
  const Vector3 from_target = p_local_m_ - target.p_m;
  const double clear_m = target_clearance_m_;
  if (offset_local_m.z() >= 0.0 || clear_m <= 0.0 || from_target.z() > kFlight.direct_above * clear_m)
    return Vector3::Zero();
  Vector3 side(from_target.x(), from_target.y(), 0.0);
  if (side.norm() < kFlight.min_side_m) side = Vector3(-target.v_mps.y(), target.v_mps.x(), 0.0);
  if (side.norm() < kFlight.min_side_m) side = Vector3::UnitX();
  return kFlight.passing_offset * clear_m * side.normalized();
}

/// Side of the target on which the net is, 1: above; 0 for a volume, which captures from any side.
double InterceptFlight::side() {
  const double above_m = net_m().z() - task_.target->at(0.0).p_m.z();
  if (std::abs(above_m) > kFlight.same_height_m) side_ = above_m > 0.0 ? 1.0 : -1.0;
  return net_.height_m > 0.0 ? 0.0 : side_;
}

double InterceptFlight::face(const Vector3& place_local_m) {
  const Vector3 to = place_local_m - p_local_m_;
  if (to.head<2>().norm() > kFlight.min_heading_m) yaw_rad_ = elementary::atan2(to.y(), to.x());
  return yaw_rad_;
}

PointState InterceptFlight::state() const {
  const Reference& r = governor_.state();
  return {r.position_m, r.velocity_mps, r.acceleration_mps2};
}

}  // namespace swiftlet
