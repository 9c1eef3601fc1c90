// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/control/reference_governor.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/finite.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [s] Longest step; longer ones are divided equally. Smaller values cost time.
constexpr double kLongestStep_s = 0.02;
/// [-] Share of the acceleration limit that braking plans use; the rest is for corrections. Larger values brake later
/// and overshoot.
constexpr double kBrakingShare = 0.85;
/// [-] Least share of the acceleration limit that is left for braking at an accelerating goal. Smaller values approach
/// such a goal more slowly.
constexpr double kMinBraking = 0.25;
/// [-] Share of the jerk limit that changes of the wanted acceleration use; the rest is for corrections. Larger values
/// overshoot the speed.
constexpr double kJerkShare = 0.7;
/// [rad/s] Gain of the position error close to the goal; the velocity's is three times, the acceleration's nine times
/// as high, for three equal poles. Larger values arrive faster and amplify steps of the goal.
constexpr double kFastestPole_radps = 6.0;
/// [-] Limits of that gain by the time to reach full acceleration, and by the step. Larger values oscillate.
constexpr double kGainOfJerk = 0.4, kGainOfStep = 0.04, kHeadingGainOfStep = 0.1;
/// [-] Bisections for the admissible jerk nearest to the wanted one. More of them cost time.
constexpr int kBisections = 12;
/// [m, m/s, m/s^2 or -] Tolerance of rounding: smaller distances, errors and relative excesses count as zero. Larger
/// values end an approach early.
constexpr double kNothing = 1e-12;

double wrap_angle(double angle_rad) { return std::remainder(angle_rad, 2.0 * kPi); }

template <int N>
using Vec = Eigen::Matrix<double, N, 1>;

template <int N>
Vec<N> cut(const Vec<N>& vector, double longest) {
  const double length_sq = vector.squaredNorm();
  return length_sq > longest * longest ? Vec<N>(vector * (longest / std::sqrt(length_sq))) : vector;
}

/// Motion in the horizontal plane (N = 2) or along the vertical (N = 1).
template <int N>
struct Motion {
  Vec<N> p, v, a;

  Motion after(const Vec<N>& jerk, double dt) const {
    return {p + dt * (v + dt * (0.5 * a + dt / 6.0 * jerk)), v + dt * (a + 0.5 * dt * jerk), a + dt * jerk};
  }
};

struct AxisLimits {
  double speed, acceleration, jerk;
};

/// Approach speed as a function of the distance to the goal, with a bounded derivative along the motion: linear
/// (exponential approach) near the goal, a square root (constant deceleration) beyond, joined smoothly.
struct ApproachCurve {
  double value, slope;
};
ApproachCurve approach(double distance, double gain, double deceleration) {
  const double join = deceleration / (gain * gain);
  if (distance <= join) return {gain * distance, gain};
  const double value = std::sqrt(2.0 * deceleration * (distance - 0.5 * join));
  return {value, deceleration / value};
}

/// Velocity gained while the acceleration `a` is brought to zero by steps of dt at full jerk.
double velocity_until_level(double a, double jerk, double dt) {
  const double jerk_step = jerk * dt;
  const double rest = a - jerk_step * std::floor(a / jerk_step);
  return (a * a - rest * rest) / (2.0 * jerk) + 0.5 * rest * dt;
}

/// True when the motion keeps the speed limit now and when it levels off at once. The set of allowed velocities is
/// convex and levelling off moves the velocity along a line, so both ends suffice.
template <int N>
bool is_viable(const Motion<N>& m, const AxisLimits& limits, double dt) {
  const double limit_sq = limits.speed * limits.speed * (1.0 + kNothing);
  if (m.v.squaredNorm() > limit_sq) return false;
  const double a = m.a.norm();
  if (a < kNothing) return true;
  return (m.v + m.a * (velocity_until_level(a, limits.jerk, dt) / a)).squaredNorm() <= limit_sq;
}

/// Jerk between that of levelling off and the wanted one: as near to the wanted one as a viable next state allows.
template <int N>
Vec<N> viable_jerk(const Motion<N>& m, const Vec<N>& wanted, const AxisLimits& limits, double dt) {
  if (is_viable(m.after(wanted, dt), limits, dt)) return wanted;
  const Vec<N> level_off = -cut<N>(m.a / dt, limits.jerk);
  double good = 0.0, bad = 1.0;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (good + bad);
    const Vec<N> jerk = level_off + middle * (wanted - level_off);
    (is_viable(m.after(jerk, dt), limits, dt) ? good : bad) = middle;
  }
  return level_off + good * (wanted - level_off);
}

/// Cascade from position error to velocity to acceleration, each along its approach curve.
template <int N>
Vec<N> wanted_acceleration(const Motion<N>& m, const Motion<N>& goal, const AxisLimits& limits, double speed_limit,
                           double gain) {
  const Vec<N> to_goal = goal.p - m.p;
  const Vec<N> w = m.v - goal.v;

  // The acceleration of the goal reduces that available for braking.
  const double braking =
      kBrakingShare * std::max(limits.acceleration - goal.a.norm(), kMinBraking * limits.acceleration);
  const double distance = to_goal.norm();
  Vec<N> v_wanted = goal.v;
  Vec<N> feed_forward = goal.a;
  if (distance > kNothing) {
    const Vec<N> direction = to_goal / distance;
    const ApproachCurve curve = approach(distance, gain, braking);
    v_wanted += curve.value * direction;
    const double w_along = direction.dot(w);
    feed_forward -= curve.slope * w_along * direction + curve.value / distance * (w - w_along * direction);
  }
  const double fastest = std::min(limits.speed, speed_limit);
  if (v_wanted.squaredNorm() > fastest * fastest) {
    v_wanted = cut<N>(v_wanted, fastest);
    feed_forward = goal.a;
  }

  const Vec<N> v_error = v_wanted - m.v;
  const double v_error_norm = v_error.norm();
  Vec<N> a_wanted = feed_forward;
  if (v_error_norm > kNothing)
    a_wanted += v_error * (approach(v_error_norm, 3.0 * gain, kJerkShare * limits.jerk).value / v_error_norm);
  return cut<N>(a_wanted, limits.acceleration);
}

/// One step. Returns the jerk; updates `m` to the end of the step.
template <int N>
Vec<N> follow(Motion<N>& m, const Motion<N>& goal, const Vec<N>& goal_a_before, const AxisLimits& limits,
              double speed_limit, double dt) {
  // A goal that is reachable within this step and viable is taken as it is.
  const Vec<N> jerk_to_goal = (goal.a - m.a) / dt;
  if (jerk_to_goal.norm() <= limits.jerk && goal.a.norm() <= limits.acceleration && is_viable(goal, limits, dt)) {
    const Motion<N> reached = m.after(jerk_to_goal, dt);
    if ((goal.v - reached.v).norm() <= 0.25 * limits.jerk * dt * dt &&
        (goal.p - reached.p).norm() <= 0.5 * limits.jerk * dt * dt * dt) {
      m = goal;
      return jerk_to_goal;
    }
  }

  const double gain = std::min({kFastestPole_radps, kGainOfJerk * limits.jerk / limits.acceleration, kGainOfStep / dt});
  Vec<N> goal_jerk = (goal.a - goal_a_before) / dt;
  if (goal_jerk.norm() > limits.jerk) goal_jerk.setZero();
  const Motion<N> coasted = m.after(goal_jerk, dt);
  const Vec<N> a_wanted = wanted_acceleration<N>(coasted, goal, limits, speed_limit, gain);
  Vec<N> jerk = cut<N>(goal_jerk + 9.0 * gain * (a_wanted - coasted.a), limits.jerk);

  // Projecting the next acceleration onto its ball keeps the jerk within its limit: projections do not expand.
  jerk = (cut<N>(m.a + dt * jerk, limits.acceleration) - m.a) / dt;
  jerk = viable_jerk<N>(m, jerk, limits, dt);
  m = m.after(jerk, dt);
  return jerk;
}

/// One step with the wanted acceleration. At the speed limit it turns the velocity instead.
template <int N>
Vec<N> push(Motion<N>& m, const Vec<N>& wanted, const AxisLimits& limits, double dt) {
  Vec<N> a = cut<N>(wanted, limits.acceleration);
  const double ahead_s = std::max(2.0 * limits.acceleration / limits.jerk, 5.0 * dt);
  const Vec<N> v_next = m.v + ahead_s * a;
  if (v_next.norm() > limits.speed) a = cut<N>((cut<N>(v_next, limits.speed) - m.v) / ahead_s, limits.acceleration);
  Vec<N> jerk = cut<N>((a - m.a) / dt, limits.jerk);
  jerk = (cut<N>(m.a + dt * jerk, limits.acceleration) - m.a) / dt;
  jerk = viable_jerk<N>(m, jerk, limits, dt);
  m = m.after(jerk, dt);
  return jerk;
}

/// Second-order tracking of the heading, with limits of rate and acceleration.
void follow_heading(double& yaw, double& rate, const Reference& goal, double goal_rate_before,
                    const MotionLimits& limits, double dt) {
  const double max_rate = limits.heading_rate_radps;
  const double max_acc = limits.heading_acceleration_radps2;
  const double acc_to_goal = (goal.yaw_rate_radps - rate) / dt;
  const double yaw_reached = yaw + 0.5 * dt * (rate + goal.yaw_rate_radps);
  if (std::abs(acc_to_goal) <= max_acc && std::abs(goal.yaw_rate_radps) <= max_rate &&
      std::abs(wrap_angle(goal.yaw_rad - yaw_reached)) <= 0.5 * max_acc * dt * dt) {
    yaw = goal.yaw_rad;
    rate = goal.yaw_rate_radps;
    return;
  }

  double goal_acc = (goal.yaw_rate_radps - goal_rate_before) / dt;
  if (std::abs(goal_acc) > max_acc) goal_acc = 0.0;
  const double rate_coasted = rate + dt * goal_acc;
  const double error = wrap_angle(goal.yaw_rad - (yaw + 0.5 * dt * (rate + rate_coasted)));
  const double gain = std::min(kFastestPole_radps, kHeadingGainOfStep / dt);
  const double braking = kBrakingShare * max_acc;
  const ApproachCurve curve = approach(std::abs(error), gain, braking);
  const double rate_unlimited = goal.yaw_rate_radps + std::copysign(curve.value, error);
  const double rate_wanted = std::clamp(rate_unlimited, -max_rate, max_rate);
  double acc = goal_acc + 3.0 * gain * (rate_wanted - rate_coasted);
  if (rate_wanted == rate_unlimited) acc -= curve.slope * (rate_coasted - goal.yaw_rate_radps);
  const double rate_next = std::clamp(rate + dt * std::clamp(acc, -max_acc, max_acc), -max_rate, max_rate);
  yaw += 0.5 * dt * (rate + rate_next);
  rate = rate_next;
}

}  // namespace

ReferenceGovernor::ReferenceGovernor(const MotionLimits& limits) : limits_(limits) {}

void ReferenceGovernor::reset(const Reference& start) {
  if (!is_finite(start)) return;
  state_ = Reference{};
  state_.position_m = start.position_m;
  state_.velocity_mps.head<2>() = cut<2>(start.velocity_mps.head<2>(), limits_.horizontal_speed_mps);
  state_.velocity_mps.tail<1>() = cut<1>(start.velocity_mps.tail<1>(), limits_.vertical_speed_mps);
  state_.yaw_rad = start.yaw_rad;
  last_goal_ = state_;
  jerk_mps3_.setZero();
}

const Reference& ReferenceGovernor::step(const Reference& wanted_goal, double dt_s, double speed_limit_mps) {
  if (!(dt_s > 0.0)) return state_;
  const Reference goal = is_finite(wanted_goal) ? wanted_goal : last_goal_;
  const int parts = dt_s <= kLongestStep_s ? 1 : static_cast<int>(std::ceil(std::min(dt_s, 10.0) / kLongestStep_s));
  for (int i = 0; i < parts; ++i) step_once(goal, dt_s / parts, speed_limit_mps);
  return state_;
}

const Reference& ReferenceGovernor::take(const Reference& feasible, double dt_s) {
  if (!(dt_s > 0.0)) return state_;
  if (!is_finite(feasible)) return step(feasible, dt_s);
  jerk_mps3_ = (feasible.acceleration_mps2 - state_.acceleration_mps2) / dt_s;
  state_ = last_goal_ = feasible;
  state_.yaw_rad = wrap_angle(state_.yaw_rad);
  return state_;
}

const Reference& ReferenceGovernor::accelerate(const Vector3& a_local_mps2, double yaw_rad, double dt_s) {
  if (!(dt_s > 0.0)) return state_;
  const Vector3 wanted = a_local_mps2.allFinite() ? a_local_mps2 : Vector3(Vector3::Zero());
  const AxisLimits horizontal{limits_.horizontal_speed_mps, limits_.horizontal_acceleration_mps2,
                              limits_.horizontal_jerk_mps3};
  const AxisLimits vertical{limits_.vertical_speed_mps, limits_.vertical_acceleration_mps2, limits_.vertical_jerk_mps3};
  Motion<2> xy{state_.position_m.head<2>(), state_.velocity_mps.head<2>(), state_.acceleration_mps2.head<2>()};
  Motion<1> z{state_.position_m.tail<1>(), state_.velocity_mps.tail<1>(), state_.acceleration_mps2.tail<1>()};
  jerk_mps3_.head<2>() = push<2>(xy, wanted.head<2>(), horizontal, dt_s);
  jerk_mps3_.tail<1>() = push<1>(z, wanted.tail<1>(), vertical, dt_s);
  state_.position_m << xy.p, z.p;
  state_.velocity_mps << xy.v, z.v;
  state_.acceleration_mps2 << xy.a, z.a;
  Reference turned = state_;
  turned.yaw_rad = yaw_rad;
  turned.yaw_rate_radps = 0.0;
  follow_heading(state_.yaw_rad, state_.yaw_rate_radps, turned, last_goal_.yaw_rate_radps, limits_, dt_s);
  state_.yaw_rad = wrap_angle(state_.yaw_rad);
  last_goal_ = state_;
  return state_;
}

void ReferenceGovernor::step_once(const Reference& goal, double dt_s, double speed_limit_mps) {
  const AxisLimits horizontal{limits_.horizontal_speed_mps, limits_.horizontal_acceleration_mps2,
                              limits_.horizontal_jerk_mps3};
  const AxisLimits vertical{limits_.vertical_speed_mps, limits_.vertical_acceleration_mps2, limits_.vertical_jerk_mps3};

  Motion<2> xy{state_.position_m.head<2>(), state_.velocity_mps.head<2>(), state_.acceleration_mps2.head<2>()};
  const Motion<2> goal_xy{goal.position_m.head<2>(), goal.velocity_mps.head<2>(), goal.acceleration_mps2.head<2>()};
  jerk_mps3_.head<2>() =
      follow<2>(xy, goal_xy, last_goal_.acceleration_mps2.head<2>(), horizontal, speed_limit_mps, dt_s);

  Motion<1> z{state_.position_m.tail<1>(), state_.velocity_mps.tail<1>(), state_.acceleration_mps2.tail<1>()};
  const Motion<1> goal_z{goal.position_m.tail<1>(), goal.velocity_mps.tail<1>(), goal.acceleration_mps2.tail<1>()};
  jerk_mps3_.tail<1>() = follow<1>(z, goal_z, last_goal_.acceleration_mps2.tail<1>(), vertical, speed_limit_mps, dt_s);

  state_.position_m << xy.p, z.p;
  state_.velocity_mps << xy.v, z.v;
  state_.acceleration_mps2 << xy.a, z.a;
  follow_heading(state_.yaw_rad, state_.yaw_rate_radps, goal, last_goal_.yaw_rate_radps, limits_, dt_s);
  state_.yaw_rad = wrap_angle(state_.yaw_rad);
  last_goal_ = goal;
}

}  // namespace swiftlet
