// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/interception/pursuit_laws.hpp"

#include <gtest/gtest.h>

namespace swiftlet {
namespace {

TEST(PursuitLaws, AreThePublishedFormulas) {
  PursuitGains gains;
  const RelativeMotion relative{{10.0, 0.0, -2.0}, {-4.0, 3.0, 0.0}};
  const double t_s = std::sqrt(104.0) / 5.0;
  const Vector3 miss_m = relative.p_m + t_s * relative.v_mps;
  EXPECT_DOUBLE_EQ(time_to_go_s(gains, relative), t_s);
  EXPECT_LT((proportional_navigation_mps2(gains, relative) - 3.0 / (t_s * t_s) * miss_m).norm(), 1e-12);
  EXPECT_LT((frpn_mps2(gains, relative) - 19.7 * (0.949 / (t_s * t_s) * miss_m + 0.051 * relative.p_m)).norm(), 1e-12);
  EXPECT_LT((pure_pursuit_mps2(gains, relative) - relative.p_m).norm(), 1e-12);
}

// On a collision course the zero-effort miss is zero.
TEST(PursuitLaws, ProportionalNavigationKeepsACollisionCourse) {
  const RelativeMotion relative{{12.0, -6.0, 3.0}, {-4.0, 2.0, -1.0}};
  EXPECT_LT(proportional_navigation_mps2({}, relative).norm(), 1e-12);
  EXPECT_GT(frpn_mps2({}, relative).norm(), 1.0) << "its share of pure pursuit still pulls";
}

TEST(PursuitLaws, TimeToGoIsBounded) {
  const PursuitGains gains;
  EXPECT_EQ(time_to_go_s(gains, {{5.0, 0.0, 0.0}, Vector3::Zero()}), gains.time_to_go_max_s);
  EXPECT_EQ(time_to_go_s(gains, {Vector3::Zero(), {5.0, 0.0, 0.0}}), gains.time_to_go_min_s);
  EXPECT_TRUE(frpn_mps2(gains, {}).allFinite());
}

TEST(PursuitLaws, LimitsKeepTheDirection) {
  MotionLimits limits;
  limits.horizontal_acceleration_mps2 = 4.0;
  limits.vertical_acceleration_mps2 = 2.0;
  const Vector3 wanted(300.0, 0.0, 300.0), got = within_acceleration(wanted, limits);
  EXPECT_LT((got - Vector3(2.0, 0.0, 2.0)).norm(), 1e-12);
  EXPECT_EQ(within_acceleration({1.0, 1.0, 1.0}, limits), Vector3(1.0, 1.0, 1.0));
}

}  // namespace
}  // namespace swiftlet
