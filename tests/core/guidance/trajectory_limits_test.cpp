// SPDX-License-Identifier: BSD-3-Clause
// Motion limits that trajectories need.
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "swiftlet/core/guidance/trajectory.hpp"
#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

using Shape = TrajectoryConfig::Shape;

bool is_allowed(const TrajectoryConfig& config, const MotionLimits& limits) {
  const AgentSetup agent;
  Module module(guidance_module_types(), "trajectory");
  module.as<TrajectoryConfig>() = config;
  try {
    make_guidance(module, {agent, limits});
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

/// Checks that these limits are the smallest allowed: each one reduced by a tenth of a percent is rejected.
void is_all_that_is_needed(const TrajectoryConfig& config, const MotionLimits& needed,
                           std::initializer_list<double MotionLimits::*> bounds) {
  ASSERT_TRUE(is_allowed(config, needed));
  for (double MotionLimits::*bound : bounds) {
    MotionLimits less = needed;
    less.*bound *= 0.999;
    EXPECT_FALSE(is_allowed(config, less)) << needed.*bound;
  }
}

TEST(TrajectoryLimits, CircleNeedsSpeedAndCentripetalAcceleration) {
  TrajectoryConfig config;
  config.speed_mps = 3.0;
  config.radius_m = 6.0;
  MotionLimits limits;
  limits.horizontal_speed_mps = 3.0;
  limits.horizontal_acceleration_mps2 = 1.5;
  limits.vertical_speed_mps = limits.vertical_acceleration_mps2 = 1e-3;  // level shapes
  is_all_that_is_needed(config, limits,
                        {&MotionLimits::horizontal_speed_mps, &MotionLimits::horizontal_acceleration_mps2});
}

TEST(TrajectoryLimits, CombineAxisBoundsForLissajous) {
  TrajectoryConfig config;
  config.shape = Shape::kLissajous;
  config.amplitude_m = {2.0, 1.5, 1.0};
  config.frequency_ratio = {1.0, 2.0, 3.0};
  config.speed_mps = 2.0;
  const double rate = 2.0 / std::sqrt(4.0 + 9.0 + 9.0);
  MotionLimits limits;
  limits.horizontal_speed_mps = rate * std::sqrt(4.0 + 9.0);
  limits.vertical_speed_mps = rate * 3.0;
  limits.horizontal_acceleration_mps2 = rate * rate * std::sqrt(4.0 + 36.0);
  limits.vertical_acceleration_mps2 = rate * rate * 9.0;
  is_all_that_is_needed(config, limits,
                        {&MotionLimits::horizontal_speed_mps, &MotionLimits::horizontal_acceleration_mps2,
                         &MotionLimits::vertical_speed_mps, &MotionLimits::vertical_acceleration_mps2});
}

// Along a line the ramp uses half of the horizontal acceleration, in any direction.
TEST(TrajectoryLimits, ScaleWithDirectionForLine) {
  TrajectoryConfig config;
  config.shape = Shape::kLine;
  config.from_m = {1.0, 2.0, 3.0};
  config.to_m = config.from_m + Vector3(3.0, 4.0, 12.0) * 5.0;
  config.speed_mps = 2.6;
  MotionLimits limits;
  limits.horizontal_speed_mps = 2.6 * 5.0 / 13.0;
  limits.vertical_speed_mps = 2.6 * 12.0 / 13.0;
  limits.horizontal_acceleration_mps2 = 2.0;
  limits.vertical_acceleration_mps2 = 0.5 * 2.0 * 12.0 / 13.0;
  is_all_that_is_needed(config, limits,
                        {&MotionLimits::horizontal_speed_mps, &MotionLimits::vertical_speed_mps,
                         &MotionLimits::vertical_acceleration_mps2});
  // Too short for its speed: it needs no more than what it reaches in a ramp.
  config.to_m = config.from_m + Vector3(0.0, 0.0, 1.5);
  const double ramp_s = 1.875 * 2.6 / (0.5 * 2.0);
  limits.vertical_speed_mps = 1.5 / ramp_s;
  limits.vertical_acceleration_mps2 = 1.875 * 1.5 / (ramp_s * ramp_s);
  is_all_that_is_needed(config, limits, {&MotionLimits::vertical_speed_mps, &MotionLimits::vertical_acceleration_mps2});
}

}  // namespace
}  // namespace swiftlet
