// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/compass.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/sample_statistics.hpp"
#include "tests/support/sensor_driver.hpp"

namespace swiftlet::sim {
namespace {

TEST(Compass, WithoutNoiseGivesTheHeadingWrapped) {
  CompassConfig config;
  config.sigma_deg = config.bias_sigma_deg = config.disturbance_sigma_deg = 0.0;
  const auto sensor = make_compass_sensor(config, sensor_setup("compass"));
  const Motion turning = [](double t) { return state_at(Vector3::Zero(), 5.0 * t); };
  const Observation seen = drive(*sensor, {turning}, {.duration_s = 3.0});
  ASSERT_EQ(seen.compass.size(), 151U);
  for (const CompassSample& sample : seen.compass) {
    EXPECT_LE(std::abs(sample.yaw_rad), std::numbers::pi);
    EXPECT_NEAR(std::remainder(sample.yaw_rad - 5.0 * to_seconds(sample.t), 2.0 * std::numbers::pi), 0.0, 1e-9);
  }
}

TEST(Compass, ErrorsHaveTheStatedSigma) {
  SampleStatistics error;
  double sigma_rad = 0.0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    const auto sensor = make_compass_sensor(CompassConfig{}, sensor_setup("compass", seed));
    const Observation seen = drive(*sensor, {resting(Vector3::Zero())}, {.duration_s = 0.1});
    error.add(seen.compass.back().yaw_rad);
    sigma_rad = seen.compass.back().sigma_rad;
  }
  EXPECT_NEAR(sigma_rad, std::sqrt(1.0 + 4.0 + 1.0) * std::numbers::pi / 180.0, 1e-12);
  EXPECT_NEAR(error.variance(), sigma_rad * sigma_rad, variance_bound(sigma_rad * sigma_rad, error.size()));
}

}  // namespace
}  // namespace swiftlet::sim
