// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/chase_planner.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

struct PlannerTuning {
  /// [-] Share of the motion limits that plans use, so that the reference governor follows them unchanged.
  double limit_share = 0.985;
  double step_grain_s = 0.0125;     ///< [s] grain of the step length; successive plans of equal steps start warm
  double beyond_meeting = 1.3;      ///< [-] horizon in multiples of the time to go
  double meeting_s = 0.5;           ///< [s] duration of the meeting; larger values stay with the target longer
  double meeting_grain_s = 0.05;    ///< [s] resolution of the time to go
  double crossing_grain_s = 0.025;  ///< [s] resolution of the time at which a disc crosses the target's height
  double rounding = 1e-9;           ///< [-] share of a grain that is a rounding error; larger values shorten steps
};
constexpr PlannerTuning kPlanner;

MotionLimits slower(MotionLimits limits) {
  for (double* limit :
       {&limits.horizontal_speed_mps, &limits.horizontal_acceleration_mps2, &limits.horizontal_jerk_mps3,
        &limits.vertical_speed_mps, &limits.vertical_acceleration_mps2, &limits.vertical_jerk_mps3}) {
    *limit *= kPlanner.limit_share;
  }
  return limits;
}

/// Displacement from the motion at constant velocity that is reached within a time, with full acceleration after its
/// build-up at full jerk.
double reachable_m(double t_s, double acceleration, double jerk) {
  const double pushed_s = std::max(0.0, t_s - 0.5 * acceleration / jerk);
  return 0.5 * acceleration * pushed_s * pushed_s;
}

}  // namespace

ChasePlanner::ChasePlanner(const ChasePlanConfig& config, const MotionLimits& limits, double reach_m)
    : config_(config), limits_(slower(limits)), reach_m_(reach_m), mpc_(config.solver, limits_, config.steps) {}

void ChasePlanner::forget() {
  planned_ = false;
  amid_for_s_ = 0.0;
  mpc_.forget();
}

void ChasePlanner::plan(const PointState& self, const TargetPrediction& target, const Vector3& to_target_local_m,
                        double side, const Surroundings& surroundings, double since_last_s) {
  time_to_go_s_ = std::min(config_.horizon_max_s, least_time_s(self, target, to_target_local_m));
  const int n = mpc_.num_steps();
  const double horizon_s =
      std::clamp(kPlanner.beyond_meeting * time_to_go_s_, config_.horizon_min_s, config_.horizon_max_s);
  const double step_s = std::ceil(horizon_s / n / kPlanner.step_grain_s - kPlanner.rounding) * kPlanner.step_grain_s;
  const double meeting_s = std::min(time_to_go_s_, (n - 1) * step_s);
  const double last_step_s = mpc_.step_s();
  const std::optional<double> crossing = crossing_s(target, to_target_local_m, since_last_s);
  for (int k = 0; k < n; ++k) {
    const double t_s = (k + 1) * step_s;
    const PointState then = target.at(t_s);
    ChaseAim& aim = aims_[static_cast<std::size_t>(k)];
    aim.p_m = then.p_m - to_target_local_m;
    // A disc captures a target that passes through it. So the vehicle stays above or below the target until the target
    // is within the radius of the disc.
    const double above_m = crossing ? config_.crossing_mps * (*crossing - t_s) : config_.hold_m;
    aim.p_m.z() += side * std::clamp(above_m, -config_.through_m, config_.hold_m);
    aim.v_mps = then.v_mps;
    const bool meets = t_s >= meeting_s && t_s < meeting_s + std::max(kPlanner.meeting_s, 1.01 * step_s);
    aim.weight = t_s < meeting_s ? config_.weight_before : meets ? 1.0 : config_.weight_after;
    aim.velocity_weight = meets ? config_.velocity_weight : 0.0;
    // Walls are needed where the vehicle will be: on its last plan, else on the straight line.
    const Vector3 there =
        planned_ && t_s + since_last_s < n * last_step_s
            ? mpc_.at(t_s + since_last_s).p_m
            : Vector3(self.p_m + std::min(1.0, t_s / std::max(meeting_s, step_s)) * (aim.p_m - self.p_m));
    surroundings.walls(there, t_s, aim);
  }
  mpc_.solve(self, std::span(aims_.data(), static_cast<std::size_t>(n)), step_s);
  planned_ = true;
}

/// Time at which the disc crosses the target's height: while the target is within its radius in the plane, if the last
/// plan is flown on. Empty: the target is never within reach.
std::optional<double> ChasePlanner::crossing_s(const TargetPrediction& target, const Vector3& to_target_m,
                                               double since_last_s) {
  amid_for_s_ = planned_ ? amid_for_s_ + since_last_s : 0.0;
  std::optional<double> enters_s;
  double leaves_s = 0.0;
  const int instants =
      planned_ ? static_cast<int>((horizon_s() - since_last_s) / kPlanner.crossing_grain_s + kPlanner.rounding) : -1;
  for (int i = 0; i <= instants; ++i) {
    const double t_s = i * kPlanner.crossing_grain_s;
    const Vector3 off_m = target.at(t_s).p_m - to_target_m - mpc_.at(t_s + since_last_s).p_m;
    const bool amid = off_m.head<2>().norm() < reach_m_;
    if (!amid && i == 0) amid_for_s_ = 0.0;
    if (!amid && enters_s) break;
    if (!amid) continue;
    if (!enters_s) enters_s = i == 0 ? -amid_for_s_ : t_s;
    leaves_s = t_s;
  }
  if (!enters_s) return std::nullopt;
  return *enters_s + std::min(0.5 * (leaves_s - *enters_s), config_.crossing_delay_s);
}

/// Lower bound: speed along the whole path and acceleration from the present velocity must both suffice. Beyond the
/// longest horizon only the speed counts.
double ChasePlanner::least_time_s(const PointState& self, const TargetPrediction& target,
                                  const Vector3& to_target_m) const {
  const int steps = static_cast<int>(config_.horizon_max_s / kPlanner.meeting_grain_s);
  for (int i = 1; i < steps; ++i) {
    const double t_s = i * kPlanner.meeting_grain_s;
    const Vector3 displacement_m = target.at(t_s).p_m - to_target_m - self.p_m;
    const Vector3 missing_m = displacement_m - t_s * self.v_mps;
    if (displacement_m.head<2>().norm() - reach_m_ > t_s * limits_.horizontal_speed_mps) continue;
    if (std::abs(displacement_m.z()) > t_s * limits_.vertical_speed_mps) continue;
    if (missing_m.head<2>().norm() - reach_m_ >
        reachable_m(t_s, limits_.horizontal_acceleration_mps2, limits_.horizontal_jerk_mps3))
      continue;
    if (std::abs(missing_m.z()) > reachable_m(t_s, limits_.vertical_acceleration_mps2, limits_.vertical_jerk_mps3))
      continue;
    return t_s;
  }
  const Vector3 left_m = target.at(config_.horizon_max_s).p_m - to_target_m - self.p_m;
  return std::max(config_.horizon_max_s, left_m.norm() / limits_.horizontal_speed_mps);
}

}  // namespace swiftlet
