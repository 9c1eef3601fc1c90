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
  conditions.sigmas = 3.5;  // all of it reserved
  EXPECT_NEAR(predicted_distance_m(conditions), 0.9, 1e-12);
}

TEST(RblPrediction, AnIntruderIsPassedByAsFarAsTheTimeIsLeftToStepAside) {
  RblConditions conditions;
  conditions.intruder_mps = 4.0;
  EXPECT_NEAR(predicted_distance_m(conditions), 0.9, 1e-12);  // 3 s are left
  conditions.rate_hz = 0.8;
  conditions.latency_s = 0.1;
  const double left_s = (15.0 - 1.1) / 4.0 - 2.0 / 0.8 - 0.1 - 0.3;
  ASSERT_LT(left_s * left_s, 0.9);
  EXPECT_NEAR(predicted_distance_m(conditions), left_s * left_s, 1e-12);
  conditions.rate_hz = 0.5;
  EXPECT_EQ(predicted_distance_m(conditions), 0.0);
}

TEST(RblPrediction, WhoIsWarnedAsLongAsNeededComesAsideByTheDistance) {
  for (const double speed_mps : {0.5, 1.0, 4.0}) {  // it reaches its speed on the way, or not
    for (const double acceleration_mps2 : {1.0, 2.5}) {
      RblConditions conditions;
      conditions.speed_mps = speed_mps;
      conditions.acceleration_mps2 = acceleration_mps2;
      conditions.latency_s = 0.2;
      conditions.rate_hz = 4.0;
      const double aside_s = needed_warning_s(conditions) - 2.0 / 4.0 - 0.2 - conditions.reaction_s;
      EXPECT_NEAR(way_from_rest_m(aside_s, speed_mps, acceleration_mps2), 1.1, 1e-12) << speed_mps;
    }
  }
}

TEST(RblPrediction, NothingIsPromisedWhereAnIntruderMayComeFromBehind) {
  RblConditions conditions;
  conditions.all_around = false;
  EXPECT_GT(predicted_distance_m(conditions), 0.0);
  conditions.intruder_mps = 1.0;
  EXPECT_EQ(predicted_distance_m(conditions), 0.0);
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
  EXPECT_EQ(alone.intruder_mps, 0.0);  // it never comes
  EXPECT_THROW(conditions_of(scenario_with("square", 1)), std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet::tools
