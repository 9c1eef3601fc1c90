// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/chase_planner.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace swiftlet {
namespace {

const MotionLimits kChaser{8.0, 4.0, 60.0, 4.0, 2.0, 60.0, 2.0, 2.0};
constexpr double kReach_m = 1.0;

TargetPrediction hovering(const Vector3& p_local_m) {
  Track track;
  track.position_m = p_local_m;
  return TargetPrediction({}, track, nullptr, 0);
}

Surroundings nothing_around() {
  Surroundings around;
  GeofenceConfig config;
  config.min_m = {-1e4, -1e4, -1e4};
  config.max_m = {1e4, 1e4, 1e4};
  around.fence = Geofence(config, FrameChange());
  return around;
}

double time_to_go_s(const PointState& self, const Vector3& target_local_m,
                    const Vector3& to_target_m = Vector3::Zero()) {
  ChasePlanConfig config;
  config.horizon_max_s = 30.0;
  ChasePlanner planner(config, kChaser, kReach_m);
  planner.plan(self, hovering(target_local_m), to_target_m, 0.0, nothing_around(), 0.0);
  return planner.time_to_go_s();
}

TEST(ChasePlanner, FindsNearlyLeastTimeToGo) {
  const auto least_s = [](double distance_m, double speed_mps, double acceleration_mps2) {
    return std::max(distance_m / speed_mps, std::sqrt(2.0 * distance_m / acceleration_mps2));
  };
  for (const double distance_m : {2.0, 5.0, 12.0, 20.0, 60.0, 150.0}) {
    const double level_s =
        least_s(distance_m - kReach_m, kChaser.horizontal_speed_mps, kChaser.horizontal_acceleration_mps2);
    const double upright_s = least_s(0.5 * distance_m, kChaser.vertical_speed_mps, kChaser.vertical_acceleration_mps2);
    const double level = time_to_go_s({}, {0.6 * distance_m, -0.8 * distance_m, 0.0});
    EXPECT_GE(level, level_s) << distance_m;
    EXPECT_LE(level, 1.02 * level_s + 0.1) << distance_m;
    const double upright = time_to_go_s({}, {0.0, 0.0, 0.5 * distance_m});
    EXPECT_GE(upright, upright_s) << distance_m;
    EXPECT_LE(upright, 1.02 * upright_s + 0.1) << distance_m;
    EXPECT_EQ(time_to_go_s({}, {0.0, 0.0, -0.5 * distance_m}), time_to_go_s({}, {0.0, 0.0, 0.5 * distance_m}));
  }
}

TEST(ChasePlanner, AccountsForInitialVelocity) {
  PointState self;
  for (const Vector3& axis : {Vector3(1, 0, 0), Vector3(0, 0, 1)}) {
    self.v_mps = 2.0 * axis;
    const double rest_s = time_to_go_s({}, 8.0 * axis);
    EXPECT_LT(time_to_go_s(self, 8.0 * axis), rest_s - 0.1);
    EXPECT_GT(time_to_go_s(self, -8.0 * axis), rest_s + 0.1);
  }
}

TEST(ChasePlanner, MeetsTheTargetWithTheNet) {
  EXPECT_EQ(time_to_go_s({}, {20.0, 0.0, 0.0}, {8.0, 0.0, 0.0}), time_to_go_s({}, {12.0, 0.0, 0.0}));
  EXPECT_EQ(time_to_go_s({{3.0, 2.0, 1.0}, {}, {}}, {15.0, 2.0, 1.0}), time_to_go_s({}, {12.0, 0.0, 0.0}));
}

TEST(ChasePlanner, ExtendsHorizonBeyondTimeToGo) {
  ChasePlanConfig config;
  const auto horizon_s = [&](double distance_m) {
    ChasePlanner planner(config, kChaser, kReach_m);
    planner.plan({}, hovering({distance_m, 0.0, 0.0}), Vector3::Zero(), 0.0, nothing_around(), 0.0);
    return planner.horizon_s();
  };
  EXPECT_DOUBLE_EQ(horizon_s(1.0), config.horizon_min_s);
  EXPECT_DOUBLE_EQ(horizon_s(100.0), config.horizon_max_s);
  const double wanted_s = 1.3 * time_to_go_s({}, {5.0, 0.0, 0.0});
  EXPECT_GE(horizon_s(5.0), wanted_s - 1e-9);
  EXPECT_LT(horizon_s(5.0), 1.3 * wanted_s);
}

/// Height of the net above a target that comes toward it, when the target enters the disc's reach and leaves it again.
std::array<double, 2> heights_at_the_pass_m(double speed_mps, double side) {
  ChasePlanner planner({}, kChaser, kReach_m);
  PointState self;
  self.v_mps = {7.0, 0.0, 0.0};
  Track track;
  track.position_m = {1.6 * (speed_mps + 7.0), 0.0, 0.0};
  track.velocity_mps = {-speed_mps, 0.0, 0.0};
  std::array<double, 2> heights{};
  for (double last_x_m = track.position_m.x(); last_x_m > -kReach_m;) {
    planner.plan(self, TargetPrediction({}, track, nullptr, 0), Vector3::Zero(), side, nothing_around(), 0.05);
    for (int i = 1; i <= 10; ++i) {
      const double x_m = track.position_m.x() - 0.005 * i * speed_mps - planner.at(0.005 * i).p_m.x();
      if (x_m < kReach_m && last_x_m >= kReach_m) heights[0] = planner.at(0.005 * i).p_m.z();
      if (x_m < -kReach_m && last_x_m >= -kReach_m) heights[1] = planner.at(0.005 * i).p_m.z();
      last_x_m = x_m;
    }
    self = planner.at(0.05);
    track.position_m += 0.05 * track.velocity_mps;
  }
  return heights;
}

TEST(ChasePlanner, SweepsDiscThroughReachableTargetHeight) {
  for (const double speed_mps : {2.0, 4.0, 6.0, 8.0, 9.0}) {
    for (const double side : {-1.0, 1.0}) {
      const auto [enters_m, leaves_m] = heights_at_the_pass_m(speed_mps, side);
      EXPECT_GT(side * enters_m, 0.0) << speed_mps;
      EXPECT_LT(side * leaves_m, 0.0) << speed_mps;
    }
  }
}

TEST(ChasePlanner, ReachesHoveringTargetOnTime) {
  ChasePlanConfig config;
  ChasePlanner planner(config, kChaser, kReach_m);
  PointState self;
  planner.plan(self, hovering({6.0, 3.0, 1.0}), {0.0, 0.0, 1.0}, 0.0, nothing_around(), 0.0);
  const PointState met = planner.at(planner.time_to_go_s() + 0.1);
  EXPECT_LT((met.p_m - Vector3(6.0, 3.0, 0.0)).norm(), kReach_m + 0.3);
  for (double ahead = 0.0; const double share : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    const double x_m = planner.at(share * planner.time_to_go_s()).p_m.x();
    EXPECT_GT(x_m, ahead);
    ahead = x_m;
  }
}

TEST(ChasePlanner, StopsAtWallBeforeTarget) {
  Surroundings around = nothing_around();
  GeofenceConfig config;
  config.min_m = {-1e4, -1e4, -1e4};
  config.max_m = {4.0, 1e4, 1e4};
  around.fence = Geofence(config, FrameChange());
  ChasePlanner planner({}, kChaser, kReach_m);
  PointState self;
  double farthest_m = 0.0;
  for (int i = 0; i < 100; ++i) {
    planner.plan(self, hovering({10.0, 0.0, 0.0}), Vector3::Zero(), 0.0, around, 0.05);
    self = planner.at(0.05);
    farthest_m = std::max(farthest_m, self.p_m.x());
  }
  EXPECT_GT(farthest_m, 3.5);
  EXPECT_LT(farthest_m, 4.5);
}

}  // namespace
}  // namespace swiftlet
