// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/pursuit_laws.hpp"

#include <gtest/gtest.h>

namespace swiftlet {
namespace {

// On a collision course the zero-effort miss is zero.
TEST(PursuitLaws, ProportionalNavigationKeepsACollisionCourse) {
  const RelativeMotion relative{{12.0, -6.0, 3.0}, {-4.0, 2.0, -1.0}};
  EXPECT_LT(proportional_navigation_mps2({}, relative).norm(), 1e-12);
  const Vector3 pull_mps2 = frpn_mps2({}, relative), pursuit_mps2 = pure_pursuit_mps2({}, relative);
  EXPECT_GT(pull_mps2.norm(), 1.0) << "its share of pure pursuit still pulls";
  EXPECT_LT(pull_mps2.cross(relative.p_m).norm(), 1e-9);
  EXPECT_LT(pursuit_mps2.cross(relative.p_m).norm(), 1e-9);
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
