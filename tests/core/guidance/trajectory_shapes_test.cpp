// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/guidance/trajectory.hpp"
#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

using testing::GuidanceDriver;
using Shape = TrajectoryConfig::Shape;

/// Goals from the beginning of the curve on, of a vehicle that is always where it should be.
std::vector<Reference> goals_along(const TrajectoryConfig& config, double duration_s, double tick_s = 0.01) {
  GuidanceDriver driver("trajectory", config, Vector3::Zero(), 0.2);
  driver.dt_s = tick_s;
  driver.put(driver.step().goal.position_m);
  std::vector<Reference> goals;
  goals.reserve(static_cast<std::size_t>(duration_s / tick_s) + 1);
  for (int i_t = 0; tick_s * i_t < duration_s; ++i_t) {
    goals.push_back(driver.step().goal);
    driver.put(goals.back().position_m);
  }
  return goals;
}

TEST(TrajectoryShapes, CircleHonorsPhaseAndDirection) {
  TrajectoryConfig config;
  config.center_m = {1.0, -2.0, 3.0};
  config.phase_deg = 30.0;
  for (const bool clockwise : {false, true}) {
    config.clockwise = clockwise;
    const auto goals = goals_along(config, 8.0);
    EXPECT_LT((goals[0].position_m - Vector3(1.0 + 5.0 * std::cos(M_PI / 6.0), -2.0 + 2.5, 3.0)).norm(), 1e-9);
    for (const Reference& goal : goals) {
      const Vector3 out = goal.position_m - config.center_m;
      ASSERT_NEAR(out.norm(), 5.0, 1e-9);
      ASSERT_NEAR(out.cross(goal.velocity_mps).z(), (clockwise ? -5.0 : 5.0) * goal.velocity_mps.norm(), 1e-9);
    }
    // In motion the heading follows the velocity and turns at v / r.
    EXPECT_NEAR(goals.back().yaw_rate_radps, clockwise ? -0.4 : 0.4, 1e-9);
    EXPECT_NEAR(
        std::remainder(goals.back().yaw_rad - std::atan2(goals.back().velocity_mps.y(), goals.back().velocity_mps.x()),
                       2.0 * M_PI),
        0.0, 1e-9);
  }
}

TEST(TrajectoryShapes, LissajousIsSinusoidalInEachAxis) {
  TrajectoryConfig config;
  config.shape = Shape::kLissajous;
  config.center_m = {1.0, -2.0, 3.0};
  config.amplitude_m = {4.0, 3.0, 1.0};
  config.frequency_ratio = {1.0, 2.0, 3.0};
  config.phase_deg = 20.0;
  config.speed_mps = 1.0;
  for (const Reference& goal : goals_along(config, 60.0, 0.1)) {
    // Two axes determine the parameter and so the third axis: sin and cos of the first one's angle.
    const Vector3 sine = (goal.position_m - config.center_m).cwiseQuotient(config.amplitude_m);
    ASSERT_NEAR(std::abs(sine.y()), std::abs(2.0 * sine.x()) * std::sqrt(std::max(0.0, 1.0 - sine.x() * sine.x())),
                1e-6);
    ASSERT_NEAR(sine.z(), 3.0 * sine.x() - 4.0 * std::pow(sine.x(), 3), 1e-6);
  }
  const Vector3 first_m = goals_along(config, 0.1)[0].position_m;
  const double phase = M_PI / 9.0;
  EXPECT_LT(
      (first_m - Vector3(1.0 + 4.0 * std::sin(phase), -2.0 + 3.0 * std::sin(2.0 * phase), 3.0 + std::sin(3.0 * phase)))
          .norm(),
      1e-3);
}

TEST(TrajectoryShapes, LineGoesThereAndBack) {
  TrajectoryConfig config;
  config.shape = Shape::kLine;
  config.from_m = {0.0, 0.0, 2.0};
  config.to_m = {3.0, 4.0, 2.0};
  config.speed_mps = 1.0;
  const auto goals = goals_along(config, 60.0);
  double nearest_m = 10.0, turns = 0;
  for (std::size_t i = 1; i < goals.size(); ++i) {
    nearest_m = std::min(nearest_m, (goals[i].position_m - config.to_m).norm());
    const double before = goals[i - 1].velocity_mps.x(), now = goals[i].velocity_mps.x();
    turns += before * now < 0.0 || (before != 0.0 && now == 0.0) ? 1 : 0;
    ASSERT_NEAR(goals[i].position_m.y(), 4.0 / 3.0 * goals[i].position_m.x(), 1e-9);
  }
  EXPECT_LT(nearest_m, 1e-3);
  EXPECT_GT(turns, 4);
}

TEST(TrajectoryShapes, FixedHeadingStays) {
  TrajectoryConfig config;
  config.yaw = TrajectoryConfig::Yaw::kFixed;
  config.yaw_deg = 45.0;
  for (const Reference& goal : goals_along(config, 3.0)) {
    ASSERT_NEAR(goal.yaw_rad, M_PI / 4.0, 1e-12);
    ASSERT_EQ(goal.yaw_rate_radps, 0.0);
  }
}

TEST(TrajectoryShapes, WaitsForVehicleAtTheStart) {
  const TrajectoryConfig config;
  const Vector3 beginning_m(5.0, 0.0, 3.0);
  const auto starts = [&](const Vector3& p_m, double speed_mps) {
    GuidanceDriver driver("trajectory", config, p_m);
    driver.estimate.v_local_mps = {0.0, speed_mps, 0.0};
    for (int i = 0; i < 10; ++i) driver.step();
    return (driver.out.goal.position_m - beginning_m).norm() > 1e-6;
  };
  EXPECT_TRUE(starts({5.0, 0.1, 3.0}, 0.1));
  EXPECT_FALSE(starts({5.0, 1.0, 3.0}, 0.0)) << "too far";
  EXPECT_FALSE(starts({5.0, 0.0, 3.0}, 1.0)) << "too fast";
}

}  // namespace
}  // namespace swiftlet
