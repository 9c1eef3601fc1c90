// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/waypoints.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

using testing::GuidanceDriver;

WaypointsConfig over(std::vector<Eigen::Vector3d> waypoints_m) {
  WaypointsConfig config;
  config.waypoints_m = std::move(waypoints_m);
  return config;
}

TEST(WaypointsDecisions, ReachesWaypointsWithinTheArrivalRadius) {
  WaypointsConfig config = over({{10, 0, 2}, {10, 9, 2}});
  config.arrival_radius_m = 0.4;
  GuidanceDriver driver("waypoints", config, {0, 0, 2});
  driver.put({9.59, 0, 2});
  EXPECT_EQ(driver.step().goal.position_m, Vector3(10, 0, 2));
  driver.put({10, 0, 2.39});
  EXPECT_EQ(driver.step().goal.position_m, Vector3(10, 9, 2));
  EXPECT_EQ(driver.out.speed_limit_mps, config.speed_mps);
  EXPECT_EQ(driver.out.mission, MissionStatus::kRunning);
  driver.put({10, 9.39, 2});
  EXPECT_EQ(driver.step().mission, MissionStatus::kDone);
  EXPECT_EQ(driver.out.goal.position_m, Vector3(10, 9, 2)) << "the goal stays at the last waypoint";
}

TEST(WaypointsDecisions, CountsDwellFromTheArrival) {
  WaypointsConfig config = over({{1, 0, 2}, {9, 0, 2}});
  config.dwell_s = 0.75;
  GuidanceDriver driver("waypoints", config, {0, 0, 2});
  driver.put({0.9, 0, 2});
  for (int tick = 1; tick <= 7; ++tick) {
    EXPECT_EQ(driver.step().goal.position_m.x(), 1.0) << tick;
    driver.put({0.3, 0, 2});  // blown away
  }
  EXPECT_EQ(driver.step().goal.position_m.x(), 9.0);
  // At the next one the dwell time starts again.
  driver.put({9, 0, 2});
  for (int tick = 1; tick <= 7; ++tick) EXPECT_EQ(driver.step().mission, MissionStatus::kRunning) << tick;
  EXPECT_EQ(driver.step().mission, MissionStatus::kDone);
}

TEST(WaypointsDecisions, ContinuesLoopsWithTheFirstWaypoint) {
  WaypointsConfig config = over({{1, 0, 2}, {2, 0, 2}, {3, 0, 2}});
  config.loop = true;
  GuidanceDriver driver("waypoints", config, {0, 0, 2});
  for (const double x : {1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0}) {
    EXPECT_EQ(driver.step().goal.position_m.x(), x);
    EXPECT_EQ(driver.out.mission, MissionStatus::kEndless);
    driver.put({x, 0, 2});
    driver.step();
    driver.put({-50, 0, 2});
  }
}

TEST(WaypointsDecisions, HeadsAlongLegsUnlessTooShort) {
  for (const bool at_next : {false, true}) {
    WaypointsConfig config = over({{3, 0.5, 2}, {3, 0.6, 2}, {3, -9, 2}});
    config.arrival_radius_m = 0.01;
    config.yaw = at_next ? WaypointsConfig::Yaw::kAtNext : WaypointsConfig::Yaw::kAlongPath;
    GuidanceDriver driver("waypoints", config, {3, 0, 2}, 0.7);
    EXPECT_NEAR(driver.step().goal.yaw_rad, M_PI / 2.0, 1e-9);
    driver.put({2, 0.5, 2});
    EXPECT_NEAR(driver.step().goal.yaw_rad, at_next ? 0.0 : M_PI / 2.0, 1e-9) << "seen from the vehicle, or the leg";
    driver.put({3, 0.5, 2});
    driver.step();
    EXPECT_NEAR(driver.out.goal.position_m.y(), 0.6, 1e-12);
    EXPECT_NEAR(driver.out.goal.yaw_rad, at_next ? 0.0 : M_PI / 2.0, 1e-9) << "0.1 m away: as before";
    driver.put({3, 0.6, 2});
    driver.step();
    EXPECT_NEAR(driver.out.goal.yaw_rad, -M_PI / 2.0, 1e-9);
  }
}

TEST(WaypointsDecisions, KeepsItsHeadingWhileDwelling) {
  WaypointsConfig config = over({{3, 0, 2}});
  config.dwell_s = 5.0;
  config.yaw = WaypointsConfig::Yaw::kAtNext;
  GuidanceDriver driver("waypoints", config, {0, 0, 2});
  driver.put({2.9, 0, 2});
  driver.step();
  driver.put({3, -5, 2});
  EXPECT_NEAR(driver.step().goal.yaw_rad, 0.0, 1e-12);
}

TEST(WaypointsDecisions, KeepsWaypointsInTheirConfiguredFrame) {
  for (const auto frame : {WaypointsConfig::Frame::kWorld, WaypointsConfig::Frame::kStart}) {
    WaypointsConfig config = over({{7, 1, 2}});
    config.frame = frame;
    config.yaw = WaypointsConfig::Yaw::kFixed;
    config.yaw_deg = 60.0;
    GuidanceDriver driver("waypoints", config, {1, 1, 1}, M_PI / 2.0);
    driver.step();
    driver.estimate.correct(level_alignment(0.3, {2, -1, 0.5}, Vector3::Zero()));
    driver.step();
    const Vector3 goal_m = driver.out.goal.position_m;
    if (frame == WaypointsConfig::Frame::kWorld) {
      EXPECT_LT((driver.estimate.T_world_local * goal_m - config.waypoints_m[0]).norm(), 1e-9);
    } else {
      EXPECT_LT((goal_m - Vector3(1 - 1, 1 + 7, 1 + 2)).norm(), 1e-9) << "ahead of the start is +y";
    }
    EXPECT_NEAR(driver.out.goal.yaw_rad, M_PI / 3.0 - 0.3, 1e-9);
    std::vector<Overlay> overlays;
    driver.guidance->append_overlays(overlays);
    ASSERT_EQ(overlays.size(), 1U);
    ASSERT_EQ(overlays[0].positions.size(), 1U);
    EXPECT_LT((overlays[0].positions[0].cast<double>() - goal_m).norm(), 1e-5);
  }
}

}  // namespace
}  // namespace swiftlet
