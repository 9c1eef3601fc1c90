// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/timed_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

const std::vector<Vector3> kBend = {{0, 0, 2}, {1, 0, 2}, {2, 0, 2}, {2, 1, 2.5}, {2, 2, 3}, {2, 3, 3}};

/// Goals of a path at every tick of its flight.
std::vector<Reference> goals_of_path(const TimedPathConfig& config, double tick_s,
                                     const Vector3& start_m = Vector3::Zero(), double start_yaw_rad = 0.0) {
  testing::GuidanceDriver driver("timed_path", config, start_m, start_yaw_rad);
  driver.dt_s = tick_s;
  std::vector<Reference> goals;
  while (driver.out.mission != MissionStatus::kDone && goals.size() < 100000) goals.push_back(driver.step().goal);
  return goals;
}

TEST(TimedPath, InterpolatesMotionAndEndsOnTime) {
  TimedPathConfig config;
  config.points_m = kBend;
  config.interval_s = 0.5;
  const std::vector<Reference> goals = goals_of_path(config, 0.004);
  const UniformSpline spline(kBend, 0.5);
  for (std::size_t i = 0; i < goals.size(); ++i) {
    const auto expected = spline.at(0.004 * static_cast<double>(i + 1));
    ASSERT_LT((goals[i].position_m - expected.p_m).norm(), 1e-9);
    ASSERT_LT((goals[i].velocity_mps - expected.v_mps).norm(), 1e-9);
    ASSERT_LT((goals[i].acceleration_mps2 - expected.a_mps2).norm(), 1e-9);
  }
  EXPECT_NEAR(0.004 * static_cast<double>(goals.size()), spline.duration_s(), 0.005);
}

TEST(TimedPath, DerivesYawRateFromYaw) {
  TimedPathConfig config;
  config.points_m = kBend;
  config.interval_s = 0.5;
  constexpr double kTick_s = 1e-3;
  const std::vector<Reference> goals = goals_of_path(config, kTick_s);
  int turning = 0;
  for (std::size_t i = 1; i + 1 < goals.size(); ++i) {
    const bool fast =
        goals[i - 1].velocity_mps.head<2>().norm() > 0.2 && goals[i + 1].velocity_mps.head<2>().norm() > 0.2;
    if (!fast) continue;
    const double rate_radps = std::remainder(goals[i + 1].yaw_rad - goals[i - 1].yaw_rad, 2.0 * M_PI) / (2.0 * kTick_s);
    ASSERT_NEAR(goals[i].yaw_rate_radps, rate_radps, 5e-3) << i;
    ASSERT_NEAR(goals[i].yaw_rad, std::atan2(goals[i].velocity_mps.y(), goals[i].velocity_mps.x()), 1e-9);
    turning += std::abs(rate_radps) > 0.5 ? 1 : 0;
  }
  EXPECT_GT(turning, 300);
}

TEST(TimedPath, KeepsItsHeadingWhileSlow) {
  TimedPathConfig config;
  config.points_m = {{0, 0, 0}, {0, 0.1, 0}, {0, 0.2, 0}, {0, 0.3, 0}, {0, 0.4, 0}};  // 0.1 m/s to the left
  config.interval_s = 1.0;
  for (const Reference& goal : goals_of_path(config, 0.01, Vector3::Zero(), 0.3)) {
    ASSERT_NEAR(goal.yaw_rad, 0.3, 1e-12);
    ASSERT_EQ(goal.yaw_rate_radps, 0.0);
  }
  config.interval_s = 0.4;  // 0.25 m/s
  EXPECT_NEAR(goals_of_path(config, 0.01, Vector3::Zero(), 0.3)[80].yaw_rad, 0.5 * M_PI, 1e-9);
}

TEST(TimedPath, UsesConfiguredFixedHeading) {
  TimedPathConfig config;
  config.points_m = kBend;
  config.yaw = TimedPathConfig::Yaw::kFixed;
  config.yaw_deg = -30.0;
  for (const Reference& goal : goals_of_path(config, 0.05)) {
    ASSERT_NEAR(goal.yaw_rad, -M_PI / 6.0, 1e-12);
    ASSERT_EQ(goal.yaw_rate_radps, 0.0);
  }
}

TEST(TimedPath, StaysAtStartWithoutPoints) {
  const std::vector<Reference> goals = goals_of_path({}, 0.01, {1, 2, 3});
  ASSERT_FALSE(goals.empty());
  for (const Reference& goal : goals) {
    EXPECT_LT((goal.position_m - Vector3(1, 2, 3)).norm(), 1e-12);
    EXPECT_LT(goal.velocity_mps.norm(), 1e-12);
  }
}

}  // namespace
}  // namespace swiftlet
