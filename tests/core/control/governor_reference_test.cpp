// SPDX-License-Identifier: BSD-3-Clause
// The governor's step beside its rules written out plainly, from the same state each time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "swiftlet/core/control/reference_governor.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

using Vec = Eigen::VectorXd;  // of the plane, or of the vertical

struct Point {
  Vec p, v, a;
};
struct Bounds {
  double v, a, j;
};

Vec shortened(const Vec& x, double most) { return x.norm() > most ? Vec(most * x.normalized()) : x; }

Point moved(const Point& m, const Vec& jerk, double h) {
  return {m.p + h * m.v + h * h / 2.0 * m.a + h * h * h / 6.0 * jerk, m.v + h * m.a + h * h / 2.0 * jerk,
          m.a + h * jerk};
}

/// Ends its acceleration tick by tick at full jerk, the last one by what is left: is it ever too fast?
bool is_allowed(const Point& m, const Bounds& b, double h) {
  const double most = b.v * std::sqrt(1.0 + 1e-12);
  double left = m.a.norm(), gained = 0.0;
  for (; left > b.j * h; left -= b.j * h) gained += h * (left - 0.5 * b.j * h);
  gained += 0.5 * h * left;
  const Vec levelled = m.a.norm() < 1e-12 ? m.v : Vec(m.v + gained * m.a.normalized());
  return m.v.norm() <= most && levelled.norm() <= most;
}

Vec within_speed(const Point& m, const Vec& jerk, const Bounds& b, double h) {
  if (is_allowed(moved(m, jerk, h), b, h)) return jerk;
  const Vec level_off = -shortened(m.a / h, b.j);
  double share = 0.0;  // to 1 part in 2^12
  for (double half = 0.5; half >= 1.0 / 4096.0; half *= 0.5) {
    if (is_allowed(moved(m, level_off + (share + half) * (jerk - level_off), h), b, h)) share += half;
  }
  return level_off + share * (jerk - level_off);
}

/// In proportion at first, then as it takes to brake steadily.
double approach_speed(double distance, double gain, double braking) {
  const double join = braking / gain / gain;
  return distance <= join ? gain * distance : std::sqrt(2.0 * braking * (distance - 0.5 * join));
}
double approach_slope(double distance, double gain, double braking) {
  return distance <= braking / gain / gain ? gain : braking / approach_speed(distance, gain, braking);
}

Point follow(const Point& m, const Point& goal, const Vec& goal_a_before, const Bounds& b, double wish, double h) {
  const Vec straight = (goal.a - m.a) / h;
  const Point there = moved(m, straight, h);
  const bool in_reach = straight.norm() <= b.j && (goal.v - there.v).norm() <= b.j * h * h / 4.0 &&
                        (goal.p - there.p).norm() <= b.j * h * h * h / 2.0;
  if (in_reach && goal.a.norm() <= b.a && is_allowed(goal, b, h)) return goal;

  const double gain = std::min(std::min(6.0, 0.4 * b.j / b.a), 0.04 / h);
  Vec goal_jerk = (goal.a - goal_a_before) / h;
  if (goal_jerk.norm() > b.j) goal_jerk.setZero();
  const Point coasted = moved(m, goal_jerk, h);
  const double braking = 0.85 * std::max(b.a - goal.a.norm(), b.a / 4.0);
  const Vec way = goal.p - coasted.p, w = coasted.v - goal.v;
  Vec v = goal.v, forward = goal.a;
  if (way.norm() > 1e-12) {
    const Vec along = way.normalized(), w_along = along.dot(w) * along;
    v += approach_speed(way.norm(), gain, braking) * along;
    forward -= approach_slope(way.norm(), gain, braking) * w_along +
               approach_speed(way.norm(), gain, braking) / way.norm() * (w - w_along);
  }
  if (v.norm() > std::min(b.v, wish)) {
    v = shortened(v, std::min(b.v, wish));
    forward = goal.a;
  }
  const Vec missing = v - coasted.v;
  Vec a = forward;
  if (missing.norm() > 1e-12) a += approach_speed(missing.norm(), 3.0 * gain, 0.7 * b.j) * missing.normalized();
  a = shortened(a, b.a);
  const Vec jerk = shortened(goal_jerk + 9.0 * gain * (a - coasted.a), b.j);
  return moved(m, within_speed(m, (shortened(m.a + h * jerk, b.a) - m.a) / h, b, h), h);
}

Point pushed(const Point& m, const Vec& wanted, const Bounds& b, double h) {
  Vec a = shortened(wanted, b.a);
  const double ahead_s = std::max(2.0 * b.a / b.j, 5.0 * h);
  if ((m.v + ahead_s * a).norm() > b.v) a = shortened((shortened(m.v + ahead_s * a, b.v) - m.v) / ahead_s, b.a);
  const Vec jerk = shortened((a - m.a) / h, b.j);
  return moved(m, within_speed(m, (shortened(m.a + h * jerk, b.a) - m.a) / h, b, h), h);
}

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

/// Yaw and rate one step later.
std::pair<double, double> turned(double yaw, double rate, double goal_yaw, double goal_rate, double goal_rate_before,
                                 const MotionLimits& l, double h) {
  const double most = l.heading_acceleration_radps2, fastest = l.heading_rate_radps;
  const double off = wrapped(goal_yaw - yaw - h * (rate + goal_rate) / 2.0);
  if (std::abs(goal_rate - rate) <= most * h && std::abs(goal_rate) <= fastest && std::abs(off) <= most * h * h / 2.0)
    return {wrapped(goal_yaw), goal_rate};
  double goal_acc = (goal_rate - goal_rate_before) / h;
  if (std::abs(goal_acc) > most) goal_acc = 0.0;
  const double coasted = rate + h * goal_acc, error = wrapped(goal_yaw - yaw - h * (rate + coasted) / 2.0);
  const double gain = std::min(6.0, 0.1 / h), braking = 0.85 * most;
  const double wish = goal_rate + (error < 0.0 ? -1.0 : 1.0) * approach_speed(std::abs(error), gain, braking);
  const double wanted = std::clamp(wish, -fastest, fastest);
  double acc = goal_acc + 3.0 * gain * (wanted - coasted);
  if (wanted == wish) acc -= approach_slope(std::abs(error), gain, braking) * (coasted - goal_rate);
  const double next = std::clamp(rate + h * std::clamp(acc, -most, most), -fastest, fastest);
  return {wrapped(yaw + h * (rate + next) / 2.0), next};
}

Point part_of(const Reference& r, int from, int size) {
  return {r.position_m.segment(from, size), r.velocity_mps.segment(from, size),
          r.acceleration_mps2.segment(from, size)};
}

/// What is known from step to step beside the state.
struct Plain {
  explicit Plain(const MotionLimits& limits_in) : limits(limits_in) {}

  Reference step(Reference r, const Reference& goal, double dt_s, double wish) {
    const int parts = dt_s > 0.02 ? static_cast<int>(std::ceil(std::min(dt_s, 10.0) / 0.02)) : 1;
    for (int i = 0; i < parts; ++i) r = once(r, goal, dt_s / parts, wish);
    return r;
  }
  Reference once(const Reference& r, const Reference& goal, double h, double wish) {
    const auto next = [&](int from, int size, const Bounds& b) {
      return follow(part_of(r, from, size), part_of(goal, from, size), last.acceleration_mps2.segment(from, size), b,
                    wish, h);
    };
    const Reference result = put_together(
        next(0, 2, level()), next(2, 1, vertical()),
        turned(r.yaw_rad, r.yaw_rate_radps, goal.yaw_rad, goal.yaw_rate_radps, last.yaw_rate_radps, limits, h));
    last = goal;
    return result;
  }
  Reference accelerate(const Reference& r, const Vector3& a_mps2, double yaw_rad, double h) {
    const Reference result =
        put_together(pushed(part_of(r, 0, 2), a_mps2.head<2>(), level(), h),
                     pushed(part_of(r, 2, 1), a_mps2.tail<1>(), vertical(), h),
                     turned(r.yaw_rad, r.yaw_rate_radps, yaw_rad, 0.0, last.yaw_rate_radps, limits, h));
    last = result;
    return result;
  }
  static Reference put_together(const Point& xy, const Point& z, const std::pair<double, double>& heading) {
    Reference r;
    r.position_m << xy.p, z.p;
    r.velocity_mps << xy.v, z.v;
    r.acceleration_mps2 << xy.a, z.a;
    std::tie(r.yaw_rad, r.yaw_rate_radps) = heading;
    return r;
  }
  Bounds level() const {
    return {limits.horizontal_speed_mps, limits.horizontal_acceleration_mps2, limits.horizontal_jerk_mps3};
  }
  Bounds vertical() const {
    return {limits.vertical_speed_mps, limits.vertical_acceleration_mps2, limits.vertical_jerk_mps3};
  }

  MotionLimits limits;
  Reference last;
};

void compare(const Reference& got, const Reference& expected) {
  ASSERT_LT((got.position_m - expected.position_m).norm(), 1e-9);
  ASSERT_LT((got.velocity_mps - expected.velocity_mps).norm(), 1e-8);
  ASSERT_LT((got.acceleration_mps2 - expected.acceleration_mps2).norm(), 1e-7);
  ASSERT_NEAR(wrapped(got.yaw_rad - expected.yaw_rad), 0.0, 1e-9);
  ASSERT_LE(std::abs(got.yaw_rad), std::numbers::pi + 1e-12);
  ASSERT_NEAR(got.yaw_rate_radps, expected.yaw_rate_radps, 1e-8);
}

MotionLimits limits_of(std::uint32_t trial) {
  if (trial % 4 == 3) return {3.0, 2.0, 5.0, 1.5, 1.0, 2.0, 0.7, 0.4};  // jerk is scarce
  MotionLimitsConfig config;
  config.set = static_cast<MotionLimitsConfig::Set>(trial % 4);
  return config.resolve();
}

/// A goal that jumps now and then, and moves in between.
struct Goals {
  Goals(std::uint32_t trial_in, double range_in_m)
      : trial(trial_in), range_m(range_in_m), random(trial_in, "test.goals") {}
  Reference at(std::uint32_t tick, double t_s) {
    if (random.uniform(tick, 0) < 0.01) jumped = tick;
    const auto draw = [&](std::uint32_t index, double most) { return random.uniform(-most, most, jumped, index); };
    const auto kind = static_cast<int>(4.0 * random.uniform(jumped, 1));
    Reference r;
    r.position_m = {draw(2, range_m), draw(3, range_m), draw(4, 0.3 * range_m)};
    r.yaw_rad = draw(5, 7.0);
    if (kind == 1) {  // around it
      const double w = draw(6, 0.9), c = std::cos(w * t_s), s = std::sin(w * t_s), up = draw(7, 0.7);
      r.position_m += Vector3(2.0 * c, 2.0 * s, up * std::sin(t_s));
      r.velocity_mps = {-2.0 * w * s, 2.0 * w * c, up * std::cos(t_s)};
      r.acceleration_mps2 = {-2.0 * w * w * c, -2.0 * w * w * s, -up * std::sin(t_s)};
      r.yaw_rad += draw(8, 0.8) * std::sin(0.5 * t_s);
      r.yaw_rate_radps = 0.5 * draw(8, 0.8) * std::cos(0.5 * t_s);
    } else if (kind == 2) {  // cannot be followed
      r.velocity_mps = {draw(6, 9.0), draw(7, 9.0), draw(8, 5.0)};
      r.acceleration_mps2 = {draw(9, 5.0), draw(10, 5.0), draw(11, 3.0)};
      r.yaw_rate_radps = draw(12, 4.0);
    }
    return r;
  }
  std::uint32_t trial;
  double range_m;
  Random random;
  std::uint32_t jumped = 0;
};

TEST(GovernorReference, EveryStepTowardAGoalIsThatOfTheRules) {
  int taken = 0;
  for (std::uint32_t trial = 0; trial < 12; ++trial) {
    const double dt_s = std::array{0.004, 0.01, 0.02, 0.07}[trial / 3];
    ReferenceGovernor governor(limits_of(trial));
    Plain plain(governor.limits());
    Goals goals(trial, trial % 2 == 0 ? 15.0 : 1.0);
    for (std::uint32_t tick = 1; tick < 1500; ++tick) {
      const Reference goal = goals.at(tick, tick * dt_s), before = governor.state();
      const double wish = goals.random.uniform(tick / 200, 99) < 0.3 ? 0.8 : 1e9;
      const Reference expected = plain.step(before, goal, dt_s, wish), got = governor.step(goal, dt_s, wish);
      ASSERT_NO_FATAL_FAILURE(compare(got, expected)) << trial << ", " << tick;
      if (dt_s <= 0.02) {
        ASSERT_LT((governor.jerk_mps3() - (got.acceleration_mps2 - before.acceleration_mps2) / dt_s).norm(),
                  1e-9 / dt_s);
      }
      taken += got.position_m == goal.position_m;
    }
  }
  EXPECT_GT(taken, 300);
}

TEST(GovernorReference, StepsAreCutToAtMostTwentyMillisecondsUpToTenSeconds) {
  for (const double dt_s : {0.0199, 0.02, 0.0201, 0.04, 0.0401, 0.5, 12.0}) {
    ReferenceGovernor governor(limits_of(1));
    Plain plain(governor.limits());
    Reference goal;
    goal.position_m = {40.0, -9.0, 5.0};
    goal.yaw_rad = 2.0;
    for (int i = 0; i < 3; ++i) {
      const Reference expected = plain.step(governor.state(), goal, dt_s, 1e9);
      ASSERT_NO_FATAL_FAILURE(compare(governor.step(goal, dt_s), expected)) << dt_s;
    }
  }
}

TEST(GovernorReference, EveryStepWithAWantedAccelerationIsThatOfTheRules) {
  for (std::uint32_t trial = 0; trial < 8; ++trial) {
    const double dt_s = trial % 2 == 0 ? 0.004 : 0.05;
    const Random random(trial, "test.push");
    ReferenceGovernor governor(limits_of(trial));
    Plain plain(governor.limits());
    for (std::uint32_t tick = 1; tick < 1500; ++tick) {
      const auto draw = [&](std::uint32_t i, double most) { return random.uniform(-most, most, tick / 40, i); };
      const double much = tick % 400 < 200 ? 8.0 : 1.0;
      const Vector3 a_mps2 = {draw(0, much), draw(1, much), draw(2, much)};
      const double yaw_rad = tick % 300 < 150 ? draw(3, 6.0) : 0.3;
      const Reference expected = plain.accelerate(governor.state(), a_mps2, yaw_rad, dt_s);
      ASSERT_NO_FATAL_FAILURE(compare(governor.accelerate(a_mps2, yaw_rad, dt_s), expected)) << trial << ", " << tick;
    }
  }
}

// Accelerations, goals and steps in turn: each goes on from where the other one left it.
TEST(GovernorReference, GoesOnFromAnAccelerationToAGoalAndBack) {
  ReferenceGovernor governor(limits_of(1));
  Plain plain(governor.limits());
  Goals goals(7, 5.0);
  for (std::uint32_t tick = 1; tick < 2000; ++tick) {
    const Reference goal = goals.at(tick, tick * 0.01), before = governor.state();
    if (tick % 50 < 25) {
      const Reference expected = plain.step(before, goal, 0.01, 1e9);
      ASSERT_NO_FATAL_FAILURE(compare(governor.step(goal, 0.01), expected)) << tick;
    } else {
      const Vector3 a_mps2 = goal.position_m - before.position_m;
      const Reference expected = plain.accelerate(before, a_mps2, goal.yaw_rad, 0.01);
      ASSERT_NO_FATAL_FAILURE(compare(governor.accelerate(a_mps2, goal.yaw_rad, 0.01), expected)) << tick;
    }
  }
}

TEST(GovernorReference, ResetCutsVelocitiesToTheirLimitsAndForgetsTheRest) {
  ReferenceGovernor governor(limits_of(1));
  for (int i = 0; i < 50; ++i) governor.accelerate({1.0, 1.0, 1.0}, 1.0, 0.01);
  Reference start;
  start.position_m = {1, 2, 3};
  start.velocity_mps = {30.0, -40.0, 7.0};
  start.acceleration_mps2 = {1, 1, 1};
  start.yaw_rad = 0.4;
  start.yaw_rate_radps = 0.5;
  governor.reset(start);
  EXPECT_EQ(governor.state().position_m, Vector3(1, 2, 3));
  EXPECT_LT((governor.state().velocity_mps - Vector3(2.4, -3.2, 2.0)).norm(), 1e-12);
  EXPECT_EQ(governor.state().acceleration_mps2, Vector3(0, 0, 0));
  EXPECT_EQ(governor.state().yaw_rad, 0.4);
  EXPECT_EQ(governor.state().yaw_rate_radps, 0.0);
  EXPECT_EQ(governor.jerk_mps3(), Vector3(0, 0, 0));
  // What is not a number is passed over.
  start.position_m.x() = std::nan("");
  governor.reset(start);
  EXPECT_EQ(governor.state().position_m.x(), 1.0);
}

TEST(GovernorReference, NoTimeMovesNothing) {
  ReferenceGovernor governor(limits_of(1));
  Reference start;
  start.velocity_mps = {1.0, 0.0, 0.0};
  governor.reset(start);
  for (const double dt_s : {0.0, -0.1, std::nan("")}) {
    EXPECT_EQ(governor.accelerate({1, 1, 1}, 1.0, dt_s).position_m, Vector3(0, 0, 0));
    EXPECT_EQ(governor.take(start, dt_s).velocity_mps, Vector3(1, 0, 0));
    EXPECT_EQ(governor.step({}, dt_s).position_m, Vector3(0, 0, 0));
  }
  // An acceleration that is not a number is none.
  EXPECT_TRUE(governor.accelerate(Vector3::Constant(std::nan("")), 0.0, 0.01).position_m.allFinite());
  EXPECT_EQ(governor.state().acceleration_mps2, Vector3(0, 0, 0));
}

TEST(GovernorReference, AReferenceThatIsTakenWrapsItsHeading) {
  ReferenceGovernor governor(limits_of(1));
  Reference told;
  told.yaw_rad = 4.0;
  EXPECT_NEAR(governor.take(told, 0.01).yaw_rad, 4.0 - 2.0 * std::numbers::pi, 1e-12);
}

}  // namespace
}  // namespace swiftlet
