// SPDX-License-Identifier: BSD-3-Clause
// Waypoints, takeoff and landing: the bounds of each decision, for a vehicle that the test places.
#include "swiftlet/core/guidance/waypoints.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "swiftlet/core/guidance/takeoff_land.hpp"
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
  EXPECT_EQ(driver.out.goal.position_m, Vector3(10, 9, 2)) << "it stays at the last";
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
    WaypointsConfig config = over({{3, 0.31, 2}, {3, 0.60, 2}, {3, -9, 2}});
    config.arrival_radius_m = 0.01;
    config.yaw = at_next ? WaypointsConfig::Yaw::kAtNext : WaypointsConfig::Yaw::kAlongPath;
    GuidanceDriver driver("waypoints", config, {3, 0, 2}, 0.7);
    EXPECT_NEAR(driver.step().goal.yaw_rad, M_PI / 2.0, 1e-9) << "0.31 m away";
    driver.put({2, 0.31, 2});
    EXPECT_NEAR(driver.step().goal.yaw_rad, at_next ? 0.0 : M_PI / 2.0, 1e-9) << "seen from the vehicle, or the leg";
    driver.put({3, 0.31, 2});
    driver.step();
    EXPECT_NEAR(driver.out.goal.position_m.y(), 0.60, 1e-12);
    EXPECT_NEAR(driver.out.goal.yaw_rad, at_next ? 0.0 : M_PI / 2.0, 1e-9) << "0.29 m away: as before";
    driver.put({3, 0.60, 2});
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
    EXPECT_GT(overlays[0].size_m, 0.1F) << "larger than the points of a path, smaller than a vehicle";
    EXPECT_LT(overlays[0].size_m, 0.2F);
  }
}

TEST(WaypointsDecisions, StopsMotorsAndRequestsAfterLanding) {
  WaypointsConfig config = over({{0, 0, 2}});
  GuidanceDriver hovers("waypoints", config, {0, 0, 2});
  for (int i = 0; i < 50; ++i) hovers.step();
  EXPECT_TRUE(hovers.out.motors_on);
  config.land_at_end = true;
  GuidanceDriver lands("waypoints", config, {0, 0, 2});
  lands.step();
  EXPECT_STREQ(lands.out.note, "landing");
  EXPECT_EQ(lands.out.mission, MissionStatus::kRunning);
  for (int i = 0; i < 50 && lands.out.motors_on; ++i) lands.step();
  EXPECT_FALSE(lands.out.motors_on);
  EXPECT_STREQ(lands.out.note, "landed");
  EXPECT_EQ(lands.out.mission, MissionStatus::kDone);
  lands.out = {};
  EXPECT_EQ(lands.step().goal.position_m, Vector3(0, 0, 0)) << "as it was handed in";
}

TEST(TakeoffLandDecisions, ClimbsToItsAltitudeAndHovers) {
  TakeoffLandConfig config;
  config.altitude_m = 3.0;
  config.hover_s = 0.95;
  config.wait_s = 0.35;
  config.climb_speed_mps = 1.7;
  GuidanceDriver driver("takeoff_land", config, {1, 2, 0.5}, 0.3);
  for (int tick = 1; tick <= 4; ++tick) {
    EXPECT_FALSE(driver.step().motors_on) << tick;
    EXPECT_STREQ(driver.out.note, "waiting");
    EXPECT_EQ(driver.out.goal.position_m, Vector3(1, 2, 3.5));
  }
  EXPECT_TRUE(driver.step().motors_on);
  EXPECT_EQ(driver.out.speed_limit_mps, 1.7);
  EXPECT_NEAR(driver.out.goal.yaw_rad, 0.3, 1e-12);
  driver.put({1, 2, 3.29});
  EXPECT_STREQ(driver.step().note, "climbing") << "0.21 m below";
  driver.put({1, 2, 3.31});
  EXPECT_STREQ(driver.step().note, "hovering");
  driver.put({1, 2, 3.0});
  for (int tick = 2; tick <= 9; ++tick) EXPECT_STREQ(driver.step().note, "hovering") << tick;
  EXPECT_STREQ(driver.step().note, "landing");
  EXPECT_NEAR(driver.out.goal.position_m.z(), 3.5 - 0.05, 1e-9) << "from the place where it hovers";
  while (driver.out.motors_on && driver.observation.t < 20 * kNsPerSecond) {
    driver.step();
  }
  EXPECT_EQ(driver.out.mission, MissionStatus::kDone);
  EXPECT_STREQ(driver.out.note, "landed");
  driver.out = {};
  EXPECT_TRUE(driver.step().motors_on) << "after the landing it says nothing any more";
}

}  // namespace
}  // namespace swiftlet
