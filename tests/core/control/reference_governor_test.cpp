// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/control/reference_governor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

constexpr double kStep_s = 0.004;

using Set = MotionLimitsConfig::Set;

MotionLimits limits_named(MotionLimitsConfig::Set set) {
  MotionLimitsConfig config;
  config.set = set;
  return config.resolve();
}

Reference at(double x, double y, double z) {
  Reference r;
  r.position_m = {x, y, z};
  return r;
}

/// Worst use of each limit, as a share of it; measured from outside by the difference of successive states.
struct Usage {
  double v_xy = 0, a_xy = 0, j_xy = 0, v_z = 0, a_z = 0, j_z = 0, rate = 0, acc = 0;
  void add(const Reference& before, const Reference& now, const MotionLimits& l, double dt) {
    const Vector3 jerk = (now.acceleration_mps2 - before.acceleration_mps2) / dt;
    v_xy = std::max(v_xy, now.velocity_mps.head<2>().norm() / l.horizontal_speed_mps);
    a_xy = std::max(a_xy, now.acceleration_mps2.head<2>().norm() / l.horizontal_acceleration_mps2);
    j_xy = std::max(j_xy, jerk.head<2>().norm() / l.horizontal_jerk_mps3);
    v_z = std::max(v_z, std::abs(now.velocity_mps.z()) / l.vertical_speed_mps);
    a_z = std::max(a_z, std::abs(now.acceleration_mps2.z()) / l.vertical_acceleration_mps2);
    j_z = std::max(j_z, std::abs(jerk.z()) / l.vertical_jerk_mps3);
    rate = std::max(rate, std::abs(now.yaw_rate_radps) / l.heading_rate_radps);
    acc = std::max(acc, std::abs(now.yaw_rate_radps - before.yaw_rate_radps) / dt / l.heading_acceleration_radps2);
  }
  void expect_within(double tolerance) const {
    for (const double share : {v_xy, a_xy, j_xy, v_z, a_z, j_z, rate, acc}) EXPECT_LE(share, 1.0 + tolerance);
  }
};

/// Least time from rest to rest over a distance under limits of speed, acceleration and jerk, long enough to reach
/// both.
double least_time(double distance, double v, double a, double j) { return distance / v + v / a + a / j; }

TEST(ReferenceGovernor, AdoptsFeasibleReferencesAndContinues) {
  MotionLimitsConfig config;
  ReferenceGovernor governor(config.resolve());
  governor.reset({});
  Reference given;
  given.position_m = {1, 2, 3};
  given.velocity_mps = {0.5, 0, 0};
  given.acceleration_mps2 = {0.1, 0, 0};
  given.yaw_rad = 0.3;
  const Reference& taken = governor.take(given, 0.01);
  EXPECT_EQ(taken.position_m, given.position_m);
  EXPECT_EQ(taken.velocity_mps, given.velocity_mps);
  EXPECT_EQ(taken.yaw_rad, given.yaw_rad);
  EXPECT_LT((governor.jerk_mps3() - Vector3(10, 0, 0)).norm(), 1e-9);
  Reference goal = given;
  goal.position_m = {9, 2, 3};
  EXPECT_LT((governor.step(goal, 0.01).position_m - given.position_m).norm(), 0.01);
  given.position_m.x() = std::nan("");
  EXPECT_TRUE(governor.take(given, 0.01).position_m.allFinite());
  Reference turned;
  turned.yaw_rad = 4.0;
  EXPECT_NEAR(governor.take(turned, 0.01).yaw_rad, 4.0 - 2.0 * std::numbers::pi, 1e-12);
}

TEST(ReferenceGovernor, ReachesFarPointQuicklyWithoutOvershoot) {
  for (const Set set : {Set::kSlow, Set::kMedium, Set::kFast, Set::kAgile}) {
    const MotionLimits l = limits_named(set);
    ReferenceGovernor governor(l);
    governor.reset(at(0, 0, 0));
    const Reference goal = at(60, 0, 0);
    double arrived = -1.0, farthest = 0.0;
    for (int i = 1; i < 30000; ++i) {
      const Reference& r = governor.step(goal, kStep_s);
      farthest = std::max(farthest, r.position_m.x());
      if (arrived < 0.0 && std::abs(r.position_m.x() - 60.0) < 0.05) arrived = i * kStep_s;
    }
    const double bound =
        least_time(60.0, l.horizontal_speed_mps, l.horizontal_acceleration_mps2, l.horizontal_jerk_mps3);
    EXPECT_GT(arrived, 0.95 * bound) << static_cast<int>(set);
    EXPECT_LT(arrived, 1.10 * bound + 0.3) << static_cast<int>(set);
    EXPECT_LT(farthest, 60.0 + 1e-3) << static_cast<int>(set);
    EXPECT_NEAR(governor.state().position_m.x(), 60.0, 1e-6) << static_cast<int>(set);
    EXPECT_EQ(governor.state().position_m.y(), 0.0) << static_cast<int>(set);
  }
}

// Full jerk up to the greatest acceleration, and full jerk down to none at the greatest speed.
TEST(ReferenceGovernor, AcceleratesAsFastAsLimitsAllow) {
  for (const Set set : {Set::kSlow, Set::kMedium, Set::kFast, Set::kAgile}) {
    const MotionLimits l = limits_named(set);
    const double v_mps = l.horizontal_speed_mps, a_mps2 = l.horizontal_acceleration_mps2,
                 j_mps3 = l.horizontal_jerk_mps3;
    ReferenceGovernor governor(l);
    for (const double missing_mps : {0.5 * v_mps, 0.2 * a_mps2 * a_mps2 / j_mps3}) {
      governor.reset(at(0, 0, 0));
      double reached_s = kStep_s;
      while (governor.step(at(1000, 0, 0), kStep_s).velocity_mps.x() < v_mps - missing_mps) {
        reached_s += kStep_s;
        ASSERT_LT(reached_s, 60.0);
      }
      const double whole_s = v_mps / a_mps2 + a_mps2 / j_mps3, ramp_s = a_mps2 / j_mps3;
      const double left_s = missing_mps < 0.5 * a_mps2 * ramp_s ? std::sqrt(2.0 * missing_mps / j_mps3)
                                                                : 0.5 * ramp_s + missing_mps / a_mps2;
      EXPECT_NEAR(reached_s, whole_s - left_s, 10.0 * kStep_s) << missing_mps << " of " << v_mps;
    }
  }
}

TEST(ReferenceGovernor, NeverExceedsLimitsForAnyGoal) {
  for (const Set set : {Set::kSlow, Set::kMedium, Set::kFast, Set::kAgile}) {
    const MotionLimits l = limits_named(set);
    for (std::uint32_t trial = 0; trial < 6; ++trial) {
      const Random random(trial, "test.governor", std::to_string(static_cast<int>(set)));
      ReferenceGovernor governor(l);
      governor.reset(at(0, 0, 0));
      Usage usage;
      Reference goal;
      for (std::uint32_t i = 0; i < 12000; ++i) {
        // Goals that jump, and jump often in some trials, with velocities and accelerations that are not feasible.
        if (random.uniform(i, 0) < (trial % 2 == 0 ? 0.005 : 0.3)) {
          for (int k = 0; k < 3; ++k) {
            goal.position_m[k] = random.uniform(-20, 20, i, 1 + k);
            goal.velocity_mps[k] = trial < 3 ? 0.0 : random.uniform(-12, 12, i, 4 + k);
            goal.acceleration_mps2[k] = trial < 4 ? 0.0 : random.uniform(-9, 9, i, 7 + k);
          }
          goal.yaw_rad = random.uniform(-10, 10, i, 10);
          goal.yaw_rate_radps = trial < 3 ? 0.0 : random.uniform(-5, 5, i, 11);
        }
        const double speed_limit = random.uniform(i / 500, 12) < 0.3 ? 0.7 : 1e9;
        const Reference before = governor.state();
        usage.add(before, governor.step(goal, kStep_s, speed_limit), l, kStep_s);
      }
      usage.expect_within(1e-6);
      if (trial != 0) continue;
      EXPECT_GT(usage.v_xy, 0.95) << "the test must reach the limits to say something";
      EXPECT_GT(usage.a_xy, 0.99);
    }
  }
}

TEST(ReferenceGovernor, KeepsLimitsUnderVaryingTimeSteps) {
  const MotionLimits l = limits_named(Set::kMedium);
  const Random random(3, "test.governor.dt");
  ReferenceGovernor governor(l);
  governor.reset(at(0, 0, 0));
  Reference goal;
  for (std::uint32_t i = 0; i < 5000; ++i) {
    if (i % 200 == 0)
      goal = at(random.uniform(-20, 20, i, 0), random.uniform(-20, 20, i, 1), random.uniform(-9, 9, i, 2));
    const double dt = i % 97 == 0 ? 0.7 : random.uniform(0.0005, 0.012, i, 3);
    const Reference& r = governor.step(goal, dt);
    ASSERT_LE(r.velocity_mps.head<2>().norm(), l.horizontal_speed_mps + 2e-3);
    ASSERT_LE(std::abs(r.velocity_mps.z()), l.vertical_speed_mps + 2e-3);
    ASSERT_LE(r.acceleration_mps2.head<2>().norm(), l.horizontal_acceleration_mps2 * (1 + 1e-9));
  }
}

/// A horizontal circle with bobbing height; within the "medium" limits.
Reference moving(double t) {
  const double w = 0.6, r = 3.0, wz = 0.8;
  Reference m;
  m.position_m = {r * std::cos(w * t), r * std::sin(w * t), 0.5 * std::sin(wz * t)};
  m.velocity_mps = {-r * w * std::sin(w * t), r * w * std::cos(w * t), 0.5 * wz * std::cos(wz * t)};
  m.acceleration_mps2 = {-r * w * w * std::cos(w * t), -r * w * w * std::sin(w * t), -0.5 * wz * wz * std::sin(wz * t)};
  m.yaw_rad = std::remainder(w * t, 2.0 * std::numbers::pi);
  m.yaw_rate_radps = w;
  return m;
}

TEST(ReferenceGovernor, TracksFeasibleTrajectoryWithoutSteadyLag) {
  ReferenceGovernor governor(limits_named(Set::kMedium));
  governor.reset(at(-4, 3, 1));
  Usage usage;
  for (int i = 1; i < 5000; ++i) {
    const Reference before = governor.state();
    const Reference& r = governor.step(moving(i * kStep_s), kStep_s);
    usage.add(before, r, governor.limits(), kStep_s);
    if (i * kStep_s < 10.0) continue;
    const Reference m = moving(i * kStep_s);
    ASSERT_EQ(r.position_m, m.position_m) << "at " << i * kStep_s;
    ASSERT_EQ(r.velocity_mps, m.velocity_mps);
    ASSERT_EQ(r.acceleration_mps2, m.acceleration_mps2);
    ASSERT_NEAR(std::remainder(r.yaw_rad - m.yaw_rad, 2 * std::numbers::pi), 0.0, 1e-12);
  }
  usage.expect_within(1e-6);
}

TEST(ReferenceGovernor, TurnsTheShortWayRound) {
  ReferenceGovernor governor(limits_named(Set::kMedium));
  Reference start = at(0, 0, 0);
  start.yaw_rad = 3.0;
  governor.reset(start);
  Reference goal = at(0, 0, 0);
  goal.yaw_rad = -3.0;  // 0.283 rad across the cut
  double turned = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double before = governor.state().yaw_rad;
    turned += std::remainder(governor.step(goal, kStep_s).yaw_rad - before, 2 * std::numbers::pi);
  }
  EXPECT_NEAR(turned, 2 * std::numbers::pi - 6.0, 1e-6);
}

TEST(ReferenceGovernor, RotatingTheGoalRotatesThePath) {
  const double c = std::cos(0.7), s = std::sin(0.7);
  ReferenceGovernor straight(limits_named(Set::kFast)), rotated(limits_named(Set::kFast));
  straight.reset(at(0, 0, 0));
  rotated.reset(at(0, 0, 0));
  for (int i = 0; i < 3000; ++i) {
    const Reference a = straight.step(i < 1200 ? at(10, 2, 1) : at(-5, 7, 1), kStep_s);
    const Reference b =
        rotated.step(i < 1200 ? at(10 * c - 2 * s, 10 * s + 2 * c, 1) : at(-5 * c - 7 * s, -5 * s + 7 * c, 1), kStep_s);
    ASSERT_NEAR(b.position_m.x(), c * a.position_m.x() - s * a.position_m.y(), 1e-6);
    ASSERT_NEAR(b.position_m.y(), s * a.position_m.x() + c * a.position_m.y(), 1e-6);
    ASSERT_NEAR(b.position_m.z(), a.position_m.z(), 1e-9);
  }
}

TEST(ReferenceGovernor, SlowsDownToAWishedSpeed) {
  ReferenceGovernor governor(limits_named(Set::kMedium));
  governor.reset(at(0, 0, 0));
  for (int i = 0; i < 1500; ++i) governor.step(at(100, 0, 0), kStep_s);
  EXPECT_NEAR(governor.state().velocity_mps.x(), 4.0, 0.01);
  for (int i = 0; i < 1000; ++i) governor.step(at(100, 0, 0), kStep_s, 1.5);
  EXPECT_NEAR(governor.state().velocity_mps.x(), 1.5, 0.01);
}

TEST(ReferenceGovernor, IgnoresNonFiniteGoals) {
  ReferenceGovernor governor(limits_named(Set::kMedium));
  governor.reset(at(1, 2, 3));
  Reference broken = at(std::nan(""), 0, 0);
  for (int i = 0; i < 100; ++i) governor.step(broken, kStep_s);
  EXPECT_EQ(governor.state().position_m, Vector3(1, 2, 3));
  governor.reset(broken);
  EXPECT_EQ(governor.state().position_m, Vector3(1, 2, 3));
}

TEST(ReferenceGovernor, ResetKeepsVelocitiesWithinTheirLimits) {
  ReferenceGovernor governor(limits_named(Set::kMedium));
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
  // NaN is ignored.
  start.position_m.x() = std::nan("");
  governor.reset(start);
  EXPECT_EQ(governor.state().position_m.x(), 1.0);
}

// The request is far beyond every limit and turns all the time.
TEST(ReferenceGovernor, KeepsLimitsUnderExcessiveAccelerationRequests) {
  ReferenceGovernor governor(limits_named(Set::kFast));
  governor.reset({});
  Usage usage;
  for (int i = 0; i < 20'000; ++i) {
    const double t_s = i * kStep_s;
    const Reference before = governor.state();
    governor.accelerate({300.0 * std::cos(0.7 * t_s), 300.0 * std::sin(1.1 * t_s), 100.0 * std::sin(0.9 * t_s)}, t_s,
                        kStep_s);
    usage.add(before, governor.state(), governor.limits(), kStep_s);
  }
  usage.expect_within(1e-6);
}

TEST(ReferenceGovernor, FollowsFeasibleAccelerationRequests) {
  ReferenceGovernor governor(limits_named(Set::kFast));
  governor.reset({});
  for (int i = 0; i < 250; ++i) governor.accelerate({2.0, 0.0, -1.0}, 0.0, kStep_s);
  EXPECT_NEAR(governor.state().acceleration_mps2.x(), 2.0, 1e-9);
  EXPECT_NEAR(governor.state().velocity_mps.x(), 2.0, 0.1);
  EXPECT_NEAR(governor.state().velocity_mps.z(), -1.0, 0.05);
}

TEST(ReferenceGovernor, TurnsToRequestedHeadingWhileAccelerating) {
  for (const double yaw_rad : {1.2, -2.9}) {
    ReferenceGovernor governor(limits_named(Set::kFast));
    governor.reset({});
    for (int i = 0; i < 1500; ++i) {
      governor.accelerate({2.0 * std::cos(0.01 * i), 0.0, 0.0}, yaw_rad, kStep_s);
      ASSERT_LE(std::abs(governor.state().yaw_rate_radps), governor.limits().heading_rate_radps * (1 + 1e-9));
      if (i < 1000) continue;
      ASSERT_NEAR(governor.state().yaw_rad, yaw_rad, 1e-3) << i;
      ASSERT_NEAR(governor.state().yaw_rate_radps, 0.0, 1e-2) << i;
    }
  }
}

TEST(ReferenceGovernor, StillTurnsAtTheSpeedLimit) {
  ReferenceGovernor governor(limits_named(Set::kFast));
  governor.reset({});
  for (int i = 0; i < 1000; ++i) governor.accelerate({4.0, 0.0, 0.0}, 0.0, kStep_s);
  EXPECT_NEAR(governor.state().velocity_mps.x(), 8.0, 0.1);
  for (int i = 0; i < 1000; ++i) governor.accelerate({4.0, 4.0, 0.0}, 0.0, kStep_s);
  EXPECT_GT(governor.state().velocity_mps.y(), 4.0);
  EXPECT_GT(governor.state().velocity_mps.norm(), 7.5);
}

TEST(ReferenceGovernor, IgnoresStepsWithoutDuration) {
  ReferenceGovernor governor(limits_named(Set::kMedium));
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

}  // namespace
}  // namespace swiftlet
