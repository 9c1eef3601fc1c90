// SPDX-License-Identifier: BSD-3-Clause
#include "rbl_prediction.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "parallel.hpp"

namespace swiftlet::tools {
namespace {

TEST(RblPrediction, FromRestTheWayIsTheIntegralOfTheSpeed) {
  double way_m = 0.0;
  for (double t_s = 0.0; t_s < 5.0; t_s += 1e-4) way_m += 1e-4 * std::min(3.0, 2.0 * (t_s + 0.5e-4));
  EXPECT_NEAR(way_from_rest_m(5.0, 3.0, 2.0), way_m, 1e-3);
  EXPECT_NEAR(way_from_rest_m(1.0, 3.0, 2.0), 1.0, 1e-12);
  EXPECT_EQ(way_from_rest_m(-1.0, 3.0, 2.0), 0.0);
}

TEST(RblPrediction, AmongThemselvesTheyLoseWhatControlAndRareNoiseTake) {
  RblConditions conditions;
  EXPECT_NEAR(predicted_distance_m(conditions), 0.9, 1e-12);
  conditions.noise = 0.2;
  EXPECT_NEAR(predicted_distance_m(conditions), 0.9 - 0.5 * 1.5 * 0.2 * 1.1, 1e-12);
  conditions.sigmas = 3.5;  // the reserve covers the whole noise
  EXPECT_NEAR(predicted_distance_m(conditions), 0.9, 1e-12);
}

TEST(RblPrediction, ASpeedIsKnownWhenALineThroughTheSamplesTellsItToAQuarter) {
  RblConditions conditions;
  conditions.intruder_mps = 2.0;
  conditions.noise = 0.15;
  conditions.rate_hz = 5.0;
  const double num = 5.0 * known_after_s(conditions) - 1.0;  // without the sample that may be lost
  // Least squares over so many samples around the middle: the slope's variance is sigma^2 over the sum of t^2.
  const auto slope_sigma_mps = [](int count) {
    double squares_s2 = 0.0;
    for (int i = 0; i < count; ++i) squares_s2 += std::pow((i - 0.5 * (count - 1)) / 5.0, 2.0);
    return 0.15 * 15.0 / std::sqrt(squares_s2);
  };
  EXPECT_GT(slope_sigma_mps(static_cast<int>(std::floor(num))), 0.25 * 2.0);
  EXPECT_LT(slope_sigma_mps(static_cast<int>(std::ceil(num)) + 1), 0.25 * 2.0);
  conditions.noise = 0.0;  // two samples remain necessary
  EXPECT_NEAR(known_after_s(conditions), 3.0 / 5.0, 1e-12);
}

TEST(RblPrediction, AnIntruderIsPassedByAsFarAsTheTimeIsLeftToStepAside) {
  RblConditions conditions;
  conditions.intruder_mps = 4.0;
  EXPECT_NEAR(predicted_distance_m(conditions), 0.9, 1e-12);  // 1.1 s remain to evade, with both at 4 m/s
  EXPECT_EQ(obstacle_of(conditions), RblObstacle::kNone);
  conditions.rate_hz = 5.0;
  conditions.latency_s = 0.1;
  const double left_s = (15.0 - 1.1) / (4.0 + 4.0) - 3.0 / 5.0 - 0.1 - 0.3;
  ASSERT_LT(left_s * left_s, kTouching_m);
  EXPECT_NEAR(predicted_distance_m(conditions), left_s * left_s, 1e-12);
  EXPECT_EQ(obstacle_of(conditions), RblObstacle::kLate);
  // A slower vehicle has more time to evade.
  conditions.speed_mps = 1.0;
  const double longer_s = (15.0 - 1.1) / (4.0 + 1.0) - 3.0 / 5.0 - 0.1 - 0.3;
  EXPECT_NEAR(predicted_distance_m(conditions), std::min(0.9, way_from_rest_m(longer_s, 1.0, 2.0)), 1e-12);
  conditions.rate_hz = 0.5;
  EXPECT_EQ(predicted_distance_m(conditions), 0.0);
}

TEST(RblPrediction, AnIntruderAsSlowAsAnybodyMayBecomeUnseenIsNotToldFromTheOthers) {
  RblConditions conditions;
  conditions.intruder_mps = conditions.speed_mps = 1.0;
  conditions.rate_hz = 1.25;
  EXPECT_EQ(obstacle_of(conditions), RblObstacle::kNone);
  conditions.rate_hz = 1.0;  // speed change between samples: sigma 2 m/s, half of it the intruder's speed
  EXPECT_EQ(predicted_distance_m(conditions), 0.0);
  EXPECT_EQ(obstacle_of(conditions), RblObstacle::kLate);
  conditions.maneuver_mps2 = 1.0;
  EXPECT_EQ(obstacle_of(conditions), RblObstacle::kNone);
}

TEST(RblPrediction, WhoIsWarnedAsLongAsNeededComesAsideByTheDistance) {
  for (const double speed_mps : {0.5, 1.0, 4.0}) {  // reaches its speed while evading, or not
    for (const double acceleration_mps2 : {1.0, 2.5}) {
      RblConditions conditions;
      conditions.speed_mps = speed_mps;
      conditions.acceleration_mps2 = acceleration_mps2;
      conditions.latency_s = 0.2;
      conditions.rate_hz = 4.0;
      conditions.intruder_mps = 3.0;
      const double aside_s = needed_warning_s(conditions) - 3.0 / 4.0 - 0.2 - conditions.reaction_s;
      EXPECT_NEAR(way_from_rest_m(aside_s, speed_mps, acceleration_mps2), 1.1, 1e-12) << speed_mps;
    }
  }
}

TEST(RblPrediction, WhereSamplesAreFartherOffThanIsReservedNothingIsPromised) {
  RblConditions conditions;
  conditions.noise = 0.12;
  EXPECT_LT(predicted_distance_m(conditions), kTouching_m);
  EXPECT_EQ(obstacle_of(conditions), RblObstacle::kNoise);
  conditions.intruder_mps = 2.0;  // recognized in time, as the vehicles are slow
  conditions.speed_mps = 1.0;
  EXPECT_EQ(obstacle_of(conditions), RblObstacle::kNoise);
  conditions.sigmas = 3.5;
  EXPECT_EQ(obstacle_of(conditions), RblObstacle::kNone);
}

TEST(RblPrediction, NothingIsPromisedWhereAnIntruderMayComeFromBehind) {
  RblConditions conditions;
  conditions.all_around = false;
  EXPECT_GT(predicted_distance_m(conditions), 0.0);
  conditions.intruder_mps = 1.0;
  EXPECT_EQ(predicted_distance_m(conditions), 0.0);
  EXPECT_EQ(obstacle_of(conditions), RblObstacle::kUnseen);
}

TEST(RblPrediction, ConditionsAreThoseOfTheScenario) {
  const RblConditions told = conditions_of(scenario_with("rbl_safety/circle_5", 1,
                                                         {{"vehicles[uav*].sensors[0].cameras", "[{fov_deg: 180}]"},
                                                          {"vehicles[uav*].sensors[0].sigma_range_relative", "0.15"},
                                                          {"vehicles[uav*].sensors[0].latency_s", "0.25"},
                                                          {"vehicles[uav*].sensors[0].rate_hz", "2"},
                                                          {"vehicles[uav*].agent.control.limits.set", "slow"},
                                                          {"vehicles[intruder].agent.guidance.speed_mps", "3.5"}}));
  EXPECT_EQ(told.noise, 0.15);
  EXPECT_EQ(told.latency_s, 0.25);
  EXPECT_EQ(told.rate_hz, 2.0);
  EXPECT_EQ(told.speed_mps, 1.0);
  EXPECT_EQ(told.acceleration_mps2, 1.0);
  EXPECT_EQ(told.intruder_mps, 3.5);
  EXPECT_FALSE(told.all_around);
  const RblConditions alone =
      conditions_of(scenario_with("rbl_safety/circle_5", 1, {{"vehicles[intruder].agent.guidance.speed_mps", "0.01"}}));
  EXPECT_EQ(alone.intruder_mps, 0.0);  // too slow to arrive
  EXPECT_THROW(conditions_of(scenario_with("square", 1)), std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet::tools
