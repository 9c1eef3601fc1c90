// SPDX-License-Identifier: BSD-3-Clause
// Trajectories beside their formulas, and the limits that they may ask for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "swiftlet/core/guidance/trajectory.hpp"
#include "swiftlet/core/math/random.hpp"
#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

using testing::GuidanceDriver;
using Shape = TrajectoryConfig::Shape;

// Up by the quintic step 10 x^3 - 15 x^4 + 6 x^5, and down by the same backwards.
TEST(RampedTravel, SpeedIsTheQuinticStepAndTheWayIsItsIntegral) {
  const Random random(3, "test.travel");
  for (std::uint32_t round = 0; round < 40; ++round) {
    const double ramp_s = random.uniform(0.3, 4.0, round, 0), asked = random.uniform(0.2, 5.0, round, 1);
    const bool endless = round % 5 == 0;
    const double length = endless ? std::numeric_limits<double>::infinity() : random.uniform(0.1, 20.0, round, 2);
    const RampedTravel travel(length, asked, ramp_s);
    const double speed = std::min(asked, length / ramp_s);
    const double end_s = endless ? 12.0 : length / speed + ramp_s;
    ASSERT_NEAR(travel.speed, speed, 1e-12);
    const auto plain = [&](double t_s) {
      const double x = std::clamp((endless ? t_s : std::min(t_s, end_s - t_s)) / ramp_s, 0.0, 1.0);
      return speed * std::pow(x, 3) * (10.0 - 15.0 * x + 6.0 * x * x);
    };
    const int steps = 2000;
    const double h = end_s / steps;
    double way = 0.0;
    for (int i = 0; i <= steps; ++i) {
      const double t_s = h * i;
      const auto [s, ds, dds] = travel.at(t_s);
      ASSERT_NEAR(s, way, 1e-6 * speed) << t_s;
      ASSERT_NEAR(ds, plain(t_s), 1e-9 * speed) << t_s;
      if (i > 0 && i < steps) {
        ASSERT_NEAR(dds, (plain(t_s + 1e-5) - plain(t_s - 1e-5)) / 2e-5, 1e-4 * speed / ramp_s);
      }
      way += h / 6.0 * (plain(t_s) + 4.0 * plain(t_s + 0.5 * h) + plain(t_s + h));
    }
    if (!endless) {
      const auto [s, ds, dds] = travel.at(end_s + 0.1);
      EXPECT_EQ(s, length);
      EXPECT_EQ(ds, 0.0);
      EXPECT_EQ(dds, 0.0);
    }
  }
}

/// Of a vehicle that is always where it should be: its trajectory begins with the first step here.
struct OnTrack : GuidanceDriver {
  explicit OnTrack(const TrajectoryConfig& config, double tick_s = 0.02)
      : GuidanceDriver("trajectory", config, {-90, 0, 0}, 0.2) {
    dt_s = tick_s;
    EXPECT_STREQ(step().note, "going to the beginning of the trajectory");
    EXPECT_EQ(out.mission, MissionStatus::kRunning);
    put(out.goal.position_m);
    EXPECT_STREQ(step().note, "") << "it is there";
  }
};

double ramp_of(const TrajectoryConfig& config) {
  return 1.875 * config.speed_mps / (0.5 * MotionLimits{}.horizontal_acceleration_mps2);
}

double heading_of(const Vector3& v_mps) { return std::atan2(v_mps.y(), v_mps.x()); }

void compare(const TrajectoryConfig& config, double t_s, const Reference& goal, const Vector3& p_m,
             const Vector3& v_mps, double& yaw_rad) {
  ASSERT_LT((goal.position_m - p_m).norm(), 1e-9) << t_s;
  ASSERT_LT((goal.velocity_mps - v_mps).norm(), 1e-9) << t_s;
  // Slower than that, a velocity does not tell where to look.
  const bool tells = v_mps.head<2>().norm() >= 0.1;
  if (tells) yaw_rad = heading_of(v_mps);
  if (config.yaw == TrajectoryConfig::Yaw::kFixed) yaw_rad = config.yaw_deg * M_PI / 180.0;
  ASSERT_NEAR(std::remainder(goal.yaw_rad - yaw_rad, 2.0 * M_PI), 0.0, 1e-7) << t_s;
}

TEST(TrajectoryFormula, CirclesLissajousCurvesAndLinesAreThoseOfTheTextbook) {
  const Random random(5, "test.trajectory");
  for (std::uint32_t round = 0; round < 12; ++round) {
    std::uint32_t index = 0;
    const auto draw = [&](double min, double max) { return random.uniform(min, max, round, index++); };
    const auto vector = [&](double level, double vertical) {
      const double x = draw(-level, level), y = draw(-level, level);
      return Vector3(x, y, draw(-vertical, vertical));
    };
    TrajectoryConfig config;
    config.shape = static_cast<Shape>(round % 3);
    config.speed_mps = draw(0.4, 1.2);
    config.laps = static_cast<int>(round / 3) % 3;
    config.center_m = vector(20.0, 5.0);
    config.radius_m = draw(2.0, 6.0);
    config.phase_deg = draw(-300.0, 300.0);
    config.clockwise = round % 2 == 1;
    config.amplitude_m = vector(5.0, 1.0);
    config.frequency_ratio = {1.0, draw(0.5, 2.5), draw(0.5, 1.5)};
    config.from_m = vector(8.0, 1.0);
    config.to_m = config.from_m + vector(12.0, 1.0);
    config.yaw = round == 4 ? TrajectoryConfig::Yaw::kFixed : TrajectoryConfig::Yaw::kAlongPath;
    config.yaw_deg = draw(-170.0, 170.0);
    const Vector3 bound = config.amplitude_m.cwiseProduct(config.frequency_ratio);
    const Vector3 way_m = config.to_m - config.from_m;
    const double infinity = std::numeric_limits<double>::infinity();
    const double rate = config.shape == Shape::kCircle      ? config.speed_mps / config.radius_m
                        : config.shape == Shape::kLissajous ? config.speed_mps / bound.norm()
                                                            : config.speed_mps;
    const double length = config.shape == Shape::kLine ? way_m.norm()
                          : config.laps > 0            ? 2.0 * M_PI * config.laps
                                                       : infinity;
    const RampedTravel travel(length, rate, ramp_of(config));
    const double end_s =
        config.laps == 0 ? infinity : (config.shape == Shape::kLine ? 2.0 * config.laps : 1.0) * travel.duration_s();
    OnTrack flight(config);
    double yaw_rad = 0.2;
    for (int i = 1; i < 4000 && i * flight.dt_s < std::min(end_s + 2.0, 60.0); ++i) {
      const double t_s = i * flight.dt_s;
      const Reference& goal = flight.step().goal;
      Vector3 p_m, v_mps;
      if (config.shape == Shape::kCircle) {
        const auto [s, ds, dds] = travel.at(t_s);
        const double sense = config.clockwise ? -1.0 : 1.0, angle = config.phase_deg * M_PI / 180.0 + sense * s;
        p_m = config.center_m + config.radius_m * Vector3(std::cos(angle), std::sin(angle), 0.0);
        v_mps = ds * sense * config.radius_m * Vector3(-std::sin(angle), std::cos(angle), 0.0);
      } else if (config.shape == Shape::kLissajous) {
        const auto [s, ds, dds] = travel.at(t_s);
        for (int axis = 0; axis < 3; ++axis) {
          const double k = config.frequency_ratio[axis], angle = k * (s + config.phase_deg * M_PI / 180.0);
          p_m[axis] = config.center_m[axis] + config.amplitude_m[axis] * std::sin(angle);
          v_mps[axis] = ds * bound[axis] * std::cos(angle);
        }
      } else {
        const double left_s = std::fmod(std::min(t_s, end_s - 1e-12), 2.0 * travel.duration_s());
        const bool back = left_s >= travel.duration_s();
        const auto [s, ds, dds] = travel.at(back ? left_s - travel.duration_s() : left_s);
        p_m = back ? Vector3(config.to_m - s * way_m.normalized()) : Vector3(config.from_m + s * way_m.normalized());
        v_mps = (back ? -ds : ds) * way_m.normalized();
      }
      ASSERT_NO_FATAL_FAILURE(compare(config, t_s, goal, p_m, v_mps, yaw_rad)) << "round " << round;
      ASSERT_EQ(flight.out.mission, config.laps == 0     ? MissionStatus::kEndless
                                    : t_s < end_s - 1e-9 ? MissionStatus::kRunning
                                                         : MissionStatus::kDone)
          << t_s << " of " << end_s;
    }
  }
}

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

/// What is allowed exactly up to here, along a level and upright: with a tenth of a percent less it is refused.
void is_all_that_is_needed(const TrajectoryConfig& config, const MotionLimits& needed,
                           std::initializer_list<double MotionLimits::*> bounds) {
  ASSERT_TRUE(is_allowed(config, needed));
  for (double MotionLimits::*bound : bounds) {
    MotionLimits less = needed;
    less.*bound *= 0.999;
    EXPECT_FALSE(is_allowed(config, less)) << needed.*bound;
  }
}

TEST(TrajectoryFormula, ACircleNeedsItsSpeedAndItsCentripetalAcceleration) {
  TrajectoryConfig config;
  config.speed_mps = 3.0;
  config.radius_m = 6.0;
  MotionLimits limits;
  limits.horizontal_speed_mps = 3.0;
  limits.horizontal_acceleration_mps2 = 1.5;
  limits.vertical_speed_mps = limits.vertical_acceleration_mps2 = 1e-3;  // it is level
  is_all_that_is_needed(config, limits,
                        {&MotionLimits::horizontal_speed_mps, &MotionLimits::horizontal_acceleration_mps2});
}

TEST(TrajectoryFormula, ALissajousCurveNeedsTheBoundsOfItsAxes) {
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

// Along a line the ramp takes half of the horizontal acceleration, whatever its direction.
TEST(TrajectoryFormula, ALineNeedsTheSharesOfItsDirection) {
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
