// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/agile.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

using testing::GuidanceDriver;

/// Within the usual limits of motion.
AgileConfig within_usual_limits() {
  AgileConfig config;
  config.speed_max_mps = 3.5;
  config.acceleration_max_mps2 = 1.8;
  config.area_min_m = {-8, -8, 2};
  config.area_max_m = {8, 8, 8};
  config.leg_min_m = 6.0;
  config.pace_min = 0.2;
  return config;
}

TEST(Agile, HeadsAlongItsVelocity) {
  GuidanceDriver driver("agile", within_usual_limits(), {0, 0, 5}, 0.4);
  driver.dt_s = 0.002;
  const double most_radps = MotionLimits{}.heading_rate_radps;
  Reference before = driver.step().goal;
  int num_fast = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Reference now = driver.step().goal;
    ASSERT_LE(std::abs(now.yaw_rate_radps), most_radps);
    const bool fast = std::min(before.velocity_mps.head<2>().norm(), now.velocity_mps.head<2>().norm()) > 0.6;
    if (fast) {
      ++num_fast;
      ASSERT_NEAR(now.yaw_rad, std::atan2(now.velocity_mps.y(), now.velocity_mps.x()), 1e-12);
      const double rate_radps = std::remainder(now.yaw_rad - before.yaw_rad, 2.0 * M_PI) / driver.dt_s;
      if (std::abs(now.yaw_rate_radps) < most_radps) {
        ASSERT_NEAR(now.yaw_rate_radps, rate_radps, 0.05);
      }
    }
    before = now;
  }
  EXPECT_GT(num_fast, 10'000);
  EXPECT_EQ(driver.out.mission, MissionStatus::kEndless);
}

TEST(Agile, FliesItsSplineInWorldFrame) {
  AgileConfig config = within_usual_limits();
  config.yaw = AgileConfig::Yaw::kFixed;
  config.yaw_deg = 90.0;
  const Vector3 start_m(1, -2, 4);
  GuidanceDriver driver("agile", config, start_m);
  driver.dt_s = 0.0703125;
  driver.estimate.correct(level_alignment(0.5, {2.0, 1.0, 0.5}, Vector3::Zero()));
  const Pose T_world_local = driver.estimate.T_world_local;
  const MotionLimits limits;
  AgileSpline spline(config, T_world_local * start_m, limits.vertical_speed_mps, limits.vertical_acceleration_mps2);
  for (int i = 1; i < 1000; ++i) {
    const Reference& r = driver.step().goal;
    spline.advance(driver.dt_s);
    ASSERT_LT((T_world_local * r.position_m - spline.reference().position_m).norm(), 1e-7);
    ASSERT_LT((T_world_local.linear() * r.velocity_mps - spline.reference().velocity_mps).norm(), 1e-6);
    ASSERT_NEAR(r.yaw_rad, std::acos(0.0) - 0.5, 1e-12);
    ASSERT_EQ(r.yaw_rate_radps, 0.0);
  }
}

TEST(Agile, RefusesMoreThanTheLimits) {
  const AgentSetup agent;
  const auto is_refused = [&](double speed_mps, double acceleration_mps2) {
    Module module(guidance_module_types(), "agile");
    module.as<AgileConfig>().speed_max_mps = speed_mps;
    module.as<AgileConfig>().acceleration_max_mps2 = acceleration_mps2;
    try {
      make_guidance(module, {agent, MotionLimits{}});
      return false;
    } catch (const std::invalid_argument&) {
      return true;
    }
  };
  EXPECT_FALSE(is_refused(4.0, 2.0));
  EXPECT_TRUE(is_refused(4.001, 2.0));
  EXPECT_TRUE(is_refused(4.0, 2.001));
}

}  // namespace
}  // namespace swiftlet
