// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/hover.hpp"

#include <gtest/gtest.h>

#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

TEST(Hover, StaysWhereAndAsItStood) {
  testing::GuidanceDriver driver("hover", HoverConfig{}, {3.0, -4.0, 5.0}, 0.8);
  driver.put({1.0, 1.0, 1.0}, -1.0);
  EXPECT_EQ(driver.step().goal.position_m, Vector3(3.0, -4.0, 5.0));
  EXPECT_NEAR(driver.out.goal.yaw_rad, 0.8, 1e-12);
  EXPECT_EQ(driver.out.goal.velocity_mps, Vector3(0, 0, 0));
  EXPECT_EQ(driver.out.mission, MissionStatus::kEndless);
}

TEST(Hover, TakesWorldPointAndDegreeHeading) {
  HoverConfig config;
  config.at = HoverConfig::At::kPoint;
  config.point_m = {7.0, 8.0, 9.0};
  config.yaw_deg = 90.0;
  testing::GuidanceDriver driver("hover", config, {0.0, 0.0, 2.0});
  EXPECT_EQ(driver.step().goal.position_m, Vector3(7.0, 8.0, 9.0));
  EXPECT_NEAR(driver.out.goal.yaw_rad, std::acos(0.0), 1e-12);
  // A correction of the local frame leaves the point in the world.
  driver.estimate.correct(level_alignment(0.5, {2.0, 1.0, 0.0}, Vector3::Zero()));
  driver.step();
  EXPECT_LT((driver.estimate.T_world_local * driver.out.goal.position_m - config.point_m).norm(), 1e-9);
  EXPECT_NEAR(driver.out.goal.yaw_rad, std::acos(0.0) - 0.5, 1e-9);
}

}  // namespace
}  // namespace swiftlet
