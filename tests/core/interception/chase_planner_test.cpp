// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/chase_planner.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace swiftlet {
namespace {

const MotionLimits kChaser{8.0, 4.0, 60.0, 4.0, 2.0, 60.0, 2.0, 2.0};
constexpr double kReach_m = 1.0;
// share of the limits used by a plan, so that the reference governor follows it exactly
constexpr double kShare = 0.985;

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

/// From rest: full acceleration after the build-up at full jerk, and at most the speed limit over the whole distance.
double time_from_rest_s(double way_m, double speed, double acceleration, double jerk) {
  if (way_m <= 0.0) return 0.0;
  return std::max(way_m / (kShare * speed),
                  0.5 * acceleration / jerk + std::sqrt(2.0 * way_m / (kShare * acceleration)));
}

double time_to_go_s(const PointState& self, const Vector3& target_local_m,
                    const Vector3& to_target_m = Vector3::Zero()) {
  ChasePlanConfig config;
  config.horizon_max_s = 30.0;
  ChasePlanner planner(config, kChaser, kReach_m);
  planner.plan(self, hovering(target_local_m), to_target_m, 0.0, nothing_around(), 0.0);
  return planner.time_to_go_s();
}

TEST(ChasePlanner, FindsLeastFeasibleTimeToGo) {
  for (const double way_m : {2.0, 5.0, 12.0, 20.0, 60.0, 150.0}) {
    const double level_s = time_from_rest_s(way_m - kReach_m, 8.0, 4.0, 60.0);
    EXPECT_NEAR(time_to_go_s({}, {0.6 * way_m, -0.8 * way_m, 0.0}), level_s + 0.025, 0.026) << way_m;
    const double upright_s = time_from_rest_s(0.5 * way_m, 4.0, 2.0, 60.0);
    EXPECT_NEAR(time_to_go_s({}, {0.0, 0.0, 0.5 * way_m}), std::min(30.0, upright_s + 0.025), 0.026) << way_m;
    EXPECT_EQ(time_to_go_s({}, {0.0, 0.0, -0.5 * way_m}), time_to_go_s({}, {0.0, 0.0, 0.5 * way_m}));
    EXPECT_NEAR(time_to_go_s({}, {way_m, 0.0, 0.5 * way_m}), std::max(level_s, upright_s) + 0.025, 0.026) << "both";
  }
}

TEST(ChasePlanner, AccountsForInitialVelocity) {
  PointState self;
  self.v_mps = {5.0, 0.0, 0.0};
  const double toward_s = time_to_go_s(self, {10.0, 0.0, 0.0}), away_s = time_to_go_s(self, {-10.0, 0.0, 0.0});
  const double rest_s = time_to_go_s({}, {10.0, 0.0, 0.0});
  EXPECT_LT(toward_s, rest_s - 0.3);
  EXPECT_GT(away_s, rest_s + 0.3);
  // 5 m/s t + a (t - t_j)^2 / 2 = 9 m; t_j: while jerk builds up the acceleration.
  const double a = kShare * 4.0, t_j = 0.5 * 4.0 / 60.0;
  EXPECT_NEAR(toward_s, t_j + (std::sqrt(25.0 + 2.0 * a * (9.0 - 5.0 * t_j)) - 5.0) / a + 0.025, 0.026);
  EXPECT_NEAR(away_s, t_j + (std::sqrt(25.0 + 2.0 * a * (9.0 + 5.0 * t_j)) + 5.0) / a + 0.025, 0.026);
  self.v_mps = {0.0, 0.0, 2.0};
  EXPECT_LT(time_to_go_s(self, {0.0, 0.0, 6.0}), time_to_go_s({}, {0.0, 0.0, 6.0}) - 0.1);
  EXPECT_GT(time_to_go_s(self, {0.0, 0.0, -6.0}), time_to_go_s({}, {0.0, 0.0, -6.0}) + 0.1);
}

TEST(ChasePlanner, MeetsTheTargetWithTheNet) {
  EXPECT_EQ(time_to_go_s({}, {20.0, 0.0, 0.0}, {8.0, 0.0, 0.0}), time_to_go_s({}, {12.0, 0.0, 0.0}));
  EXPECT_EQ(time_to_go_s({{3.0, 2.0, 1.0}, {}, {}}, {15.0, 2.0, 1.0}), time_to_go_s({}, {12.0, 0.0, 0.0}));
}

TEST(ChasePlanner, ExtendsHorizonBeyondTimeToGo) {
  ChasePlanConfig config;
  const auto horizon_s = [&](double way_m) {
    ChasePlanner planner(config, kChaser, kReach_m);
    planner.plan({}, hovering({way_m, 0.0, 0.0}), Vector3::Zero(), 0.0, nothing_around(), 0.0);
    return planner.horizon_s();
  };
  EXPECT_DOUBLE_EQ(horizon_s(1.0), config.horizon_min_s);
  EXPECT_DOUBLE_EQ(horizon_s(100.0), config.horizon_max_s);
  const double wanted_s = 1.3 * time_to_go_s({}, {5.0, 0.0, 0.0});
  EXPECT_GE(horizon_s(5.0), wanted_s - 1e-9);
  EXPECT_LT(horizon_s(5.0), wanted_s + config.steps * 0.0125) << "steps are rounded up to multiples of 12.5 ms";
}

/// Heights of the net above a hovering target, at instants of the plan.
std::vector<double> heights_m(double side, double* meeting_s) {
  ChasePlanConfig config;
  config.hold_m = 0.4;
  config.through_m = 0.3;
  config.solver.iterations = 20000;
  config.solver.tolerance = 1e-6;
  ChasePlanner planner(config, kChaser, kReach_m);
  for (int i = 0; i < 3; ++i)  // each plan starts from the meeting time of the one before
    planner.plan({}, hovering({8.0, 0.0, 0.0}), Vector3::Zero(), side, nothing_around(), 0.0);
  *meeting_s = planner.time_to_go_s();
  std::vector<double> heights;
  for (int i = 0; i <= 300; ++i) heights.push_back(planner.at(0.01 * i).p_m.z());
  return heights;
}

TEST(ChasePlanner, KeepsDiscSideUntilMeeting) {
  double meeting_s = 0.0;
  const std::vector<double> above = heights_m(1.0, &meeting_s), below = heights_m(-1.0, &meeting_s),
                            level = heights_m(0.0, &meeting_s);
  const auto meeting = static_cast<std::size_t>(meeting_s / 0.01);
  EXPECT_GT(above.at(meeting / 2), 0.02);
  EXPECT_LT(above.at(meeting + 40), -0.1);
  for (std::size_t i = 0; i < above.size(); ++i) {
    EXPECT_NEAR(below[i], -above[i], 1e-9) << "a mirror image";
    EXPECT_NEAR(level[i], 0.0, 1e-9);
  }
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
