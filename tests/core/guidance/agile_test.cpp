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
  driver.dt_s = 0.05;
  double yaw_rad = 0.4;
  int slow = 0, free = 0, cut_left = 0, cut_right = 0;
  for (int i = 0; i < 8000; ++i) {
    const Reference& r = driver.step().goal;
    const double speed_mps = r.velocity_mps.head<2>().norm(), most = MotionLimits{}.heading_rate_radps;
    double rate_radps = 0.0;
    if (speed_mps < 0.5) {
      ++slow;
    } else {
      yaw_rad = std::atan2(r.velocity_mps.y(), r.velocity_mps.x());
      rate_radps = r.velocity_mps.head<2>().dot(Eigen::Vector2d(r.acceleration_mps2.y(), -r.acceleration_mps2.x())) /
                   (speed_mps * speed_mps);
      free += std::abs(rate_radps) < most;
      cut_left += rate_radps > most;
      cut_right += rate_radps < -most;
    }
    ASSERT_NEAR(r.yaw_rad, yaw_rad, 1e-12);
    ASSERT_NEAR(r.yaw_rate_radps, std::clamp(rate_radps, -most, most), 1e-9);
  }
  for (const int seen : {slow, free, cut_left, cut_right}) EXPECT_GT(seen, 5);
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
