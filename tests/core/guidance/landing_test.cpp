// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flight/landing.hpp"

#include <gtest/gtest.h>

namespace swiftlet {
namespace {

constexpr double kLandingTick_s = 0.01;

/// A vehicle at the height and vertical speed set by the test.
StateEstimate standing_at(double z_m, double vz_mps = 0.0) {
  StateEstimate estimate;
  estimate.T_local_body.translation() = Vector3(1.0, 2.0, z_m);
  estimate.v_local_mps.z() = vz_mps;
  return estimate;
}

TEST(Landing, SinksVerticallyAtItsSpeed) {
  Landing landing(0.5);
  EXPECT_FALSE(landing.started());
  landing.start({1.0, 2.0, 3.0}, 0.7);
  EXPECT_TRUE(landing.started());
  Reference goal;
  double z_m = 3.0;
  for (int i = 1; i <= 400; ++i) {
    EXPECT_FALSE(landing.step(standing_at(z_m, -0.5), kLandingTick_s, goal)) << "landing ends only after the descent";
    z_m = goal.position_m.z();
    ASSERT_NEAR(z_m, 3.0 - 0.5 * kLandingTick_s * i, 1e-9);
    ASSERT_EQ(goal.velocity_mps, Vector3(0.0, 0.0, -0.5));
    ASSERT_EQ(goal.position_m.head<2>(), Vector3(1.0, 2.0, 0.0).head<2>());
    ASSERT_EQ(goal.yaw_rad, 0.7);
  }
}

TEST(Landing, PushesGoalHalfMeterBelowGround) {
  Landing landing(0.5);
  landing.start({1.0, 2.0, 0.2}, 0.0);
  Reference goal;
  for (int i = 0; i < 300; ++i) {
    landing.step(standing_at(0.2), kLandingTick_s, goal);
    ASSERT_GE(goal.position_m.z(), 0.2 - 0.5 - 1e-12);
  }
  EXPECT_NEAR(goal.position_m.z(), 0.2 - 0.5, 1e-12);
  EXPECT_EQ(goal.velocity_mps.z(), 0.0) << "a goal that rests has no speed";
}

/// Time from the first contact until the landing is over; negative when that never comes.
double touch_down_s(double speed_mps, double vz_mps, double longest_s = 10.0) {
  Landing landing(speed_mps);
  landing.start({0.0, 0.0, 0.2}, 0.0);
  Reference goal;
  for (int i = 1; i * kLandingTick_s <= longest_s; ++i) {
    if (landing.step(standing_at(0.2, vz_mps), kLandingTick_s, goal)) return i * kLandingTick_s;
  }
  return -1.0;
}

TEST(Landing, RefusesTouchdownWhileStillMoving) {
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_GT(touch_down_s(0.5, 0.03 * sign), 0.0);
    EXPECT_LT(touch_down_s(0.5, 0.3 * sign), 0.0);
    EXPECT_LT(touch_down_s(0.1, 0.09 * sign), 0.0) << "a slow landing is no standstill";
  }
}

TEST(Landing, RestartsTouchdownTimerAfterABounce) {
  Landing landing(0.5);
  landing.start({0.0, 0.0, 0.2}, 0.0);
  Reference goal;
  for (int i = 0; i < 100; ++i)
    ASSERT_FALSE(landing.step(standing_at(0.2), kLandingTick_s, goal));  // 0.4 s on the ground
  ASSERT_FALSE(landing.step(standing_at(0.2, 0.5), kLandingTick_s, goal));
  for (int i = 0; i < 45; ++i) ASSERT_FALSE(landing.step(standing_at(0.2), kLandingTick_s, goal));
  bool landed = false;
  for (int i = 0; i < 10; ++i) landed = landed || landing.step(standing_at(0.2), kLandingTick_s, goal);
  EXPECT_TRUE(landed);
}

}  // namespace
}  // namespace swiftlet
