// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/control/reference_governor.hpp"

namespace swiftlet {
namespace {

constexpr MotionLimits kLimits{8.0, 4.0, 60.0, 4.0, 2.0, 60.0, 2.0, 2.0};
constexpr double kDt_s = 0.004;

// A wish far beyond every limit, which turns about all the time.
TEST(ReferenceGovernor, KeepsLimitsUnderExcessiveAccelerationRequests) {
  ReferenceGovernor governor(kLimits);
  governor.reset({});
  for (int i = 0; i < 20'000; ++i) {
    const double t_s = i * kDt_s;
    governor.accelerate({300.0 * std::cos(0.7 * t_s), 300.0 * std::sin(1.1 * t_s), 100.0 * std::sin(0.9 * t_s)}, t_s,
                        kDt_s);
    const Reference& r = governor.state();
    ASSERT_LE(r.velocity_mps.head<2>().norm(), 8.0 * (1 + 1e-9));
    ASSERT_LE(std::abs(r.velocity_mps.z()), 4.0 * (1 + 1e-9));
    ASSERT_LE(r.acceleration_mps2.head<2>().norm(), 4.0 * (1 + 1e-9));
    ASSERT_LE(std::abs(r.acceleration_mps2.z()), 2.0 * (1 + 1e-9));
    ASSERT_LE(governor.jerk_mps3().head<2>().norm(), 60.0 * (1 + 1e-9));
  }
}

TEST(ReferenceGovernor, FollowsFeasibleAccelerationRequests) {
  ReferenceGovernor governor(kLimits);
  governor.reset({});
  for (int i = 0; i < 250; ++i) governor.accelerate({2.0, 0.0, -1.0}, 0.0, kDt_s);
  EXPECT_NEAR(governor.state().acceleration_mps2.x(), 2.0, 1e-9);
  EXPECT_NEAR(governor.state().velocity_mps.x(), 2.0, 0.1);
  EXPECT_NEAR(governor.state().velocity_mps.z(), -1.0, 0.05);
}

TEST(ReferenceGovernor, TurnsToRequestedHeadingWhileAccelerating) {
  for (const double yaw_rad : {1.2, -2.9}) {
    ReferenceGovernor governor(kLimits);
    governor.reset({});
    for (int i = 0; i < 1500; ++i) {
      governor.accelerate({2.0 * std::cos(0.01 * i), 0.0, 0.0}, yaw_rad, kDt_s);
      ASSERT_LE(std::abs(governor.state().yaw_rate_radps), kLimits.heading_rate_radps * (1 + 1e-9));
      if (i < 1000) continue;
      ASSERT_NEAR(governor.state().yaw_rad, yaw_rad, 1e-3) << i;
      ASSERT_NEAR(governor.state().yaw_rate_radps, 0.0, 1e-2) << i;
    }
  }
}

TEST(ReferenceGovernor, StillTurnsAtTheSpeedLimit) {
  ReferenceGovernor governor(kLimits);
  governor.reset({});
  for (int i = 0; i < 1000; ++i) governor.accelerate({4.0, 0.0, 0.0}, 0.0, kDt_s);
  EXPECT_NEAR(governor.state().velocity_mps.x(), 8.0, 0.1);
  for (int i = 0; i < 1000; ++i) governor.accelerate({4.0, 4.0, 0.0}, 0.0, kDt_s);
  EXPECT_GT(governor.state().velocity_mps.y(), 4.0);
  EXPECT_GT(governor.state().velocity_mps.norm(), 7.5);
}

}  // namespace
}  // namespace swiftlet
