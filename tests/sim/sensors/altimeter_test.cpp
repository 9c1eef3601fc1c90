// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/altimeter.hpp"

#include <gtest/gtest.h>

#include "tests/support/sample_statistics.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

// Flat ground at z = 0 with a block of 1 m height for x in 2..4.
std::shared_ptr<const StaticScene> ground_with_block() {
  TestScene builder;
  builder.add_wall({-100, -100, 0}, {100, -100, 0}, {100, 100, 0}, {-100, 100, 0}, SurfaceClass::kGround);
  builder.add_box({2, -2, 0}, {4, 2, 1});
  return std::make_shared<const StaticScene>(builder.scene());
}

AltimeterConfig perfect_altimeter() {
  AltimeterConfig config;
  config.sigma_m = 0.0;
  return config;
}

TEST(Altimeter, MeasuresHeightAboveSurfaceBelow) {
  const auto sensor = make_altimeter_sensor(perfect_altimeter(), sensor_setup("altimeter", 1, 1, ground_with_block()));
  const Motion motion = straight({0.0, 0.5, 5.0}, {3.0, 0.0, 0.0});
  const Observation seen = drive(*sensor, {motion}, {.duration_s = 2.0});
  ASSERT_EQ(seen.altimeter.size(), 101U);
  for (const AltimeterSample& sample : seen.altimeter) {
    const double x = 3.0 * to_seconds(sample.t);
    EXPECT_NEAR(sample.height_m, x > 2.0 && x < 4.0 ? 4.0 : 5.0, 1e-5) << x;
  }
}

TEST(Altimeter, AccountsForMountBelowBody) {
  AltimeterConfig config = perfect_altimeter();
  config.position_m = {0.0, 0.0, -0.3};
  const auto sensor = make_altimeter_sensor(config, sensor_setup("altimeter", 1, 1, ground_with_block()));
  EXPECT_NEAR(drive(*sensor, {resting({0.0, 0.0, 5.0})}, {}).altimeter.at(0).height_m, 5.0, 1e-5);
}

TEST(Altimeter, CorrectsBodyFixedBeamForTilt) {
  const Motion tilted = [](double) {
    VehicleState state;
    state.p_world_m = {0.0, 0.0, 5.0};
    state.q_world_body = Eigen::AngleAxisd(-0.5, Vector3::UnitY());  // nose up: looks forward, at x = 5 tan 0.5 = 2.7
    return state;
  };
  AltimeterConfig config = perfect_altimeter();
  const auto vertical = make_altimeter_sensor(config, sensor_setup("altimeter", 1, 1, ground_with_block()));
  EXPECT_NEAR(drive(*vertical, {tilted}, {}).altimeter.at(0).height_m, 5.0, 1e-5);
  config.beam = AltimeterConfig::Beam::kBody;
  const auto fixed = make_altimeter_sensor(config, sensor_setup("altimeter", 1, 1, ground_with_block()));
  EXPECT_NEAR(drive(*fixed, {tilted}, {}).altimeter.at(0).height_m, 4.0, 1e-5);  // the top of the block
}

TEST(Altimeter, MeasuresNothingOutOfRange) {
  AltimeterConfig config = perfect_altimeter();
  config.range_min_m = 1.0;
  config.range_max_m = 4.0;
  const auto heights = [&](double z) {
    const auto sensor = make_altimeter_sensor(config, sensor_setup("altimeter", 1, 1, ground_with_block()));
    return drive(*sensor, {resting({0.0, 0.0, z})}, {}).altimeter.size();
  };
  EXPECT_EQ(heights(0.9), 0U);
  EXPECT_EQ(heights(3.9), 51U);
  EXPECT_EQ(heights(4.1), 0U);
}

TEST(Altimeter, NoiseGrowsWithRangeAsStated) {
  AltimeterConfig config;
  config.sigma_m = 0.03;
  config.sigma_relative = 0.01;
  const auto sensor = make_altimeter_sensor(config, sensor_setup("altimeter", 1, 1, ground_with_block()));
  SampleStatistics height;
  const Observation seen = drive(*sensor, {resting({0.0, 0.0, 10.0})}, {.duration_s = 60.0});
  for (const AltimeterSample& sample : seen.altimeter) height.add(sample.height_m);
  const double variance = 0.03 * 0.03 + 0.1 * 0.1;
  EXPECT_NEAR(height.mean(), 10.0, mean_bound(std::sqrt(variance), height.size()));
  EXPECT_NEAR(height.variance(), variance, variance_bound(variance, height.size()));
  EXPECT_NEAR(seen.altimeter[0].sigma_m, std::sqrt(variance), 1e-6);
}

}  // namespace
}  // namespace swiftlet::sim
