// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/pose.hpp"

#include <gtest/gtest.h>

#include "sim/sensors/noise.hpp"
#include "tests/support/sample_statistics.hpp"
#include "tests/support/sensor_driver.hpp"

namespace swiftlet::sim {
namespace {

TEST(Pose, IsExactEveryTickWithoutNoise) {
  const auto sensor = make_pose_sensor(PoseConfig{}, sensor_setup("pose"));
  const Motion motion = straight({1.0, 2.0, 3.0}, {4.0, -1.0, 0.5}, 0.3);
  drive(*sensor, {motion}, {}, [&](TimeNs now, const Observation& delivered) {
    ASSERT_EQ(delivered.pose.size(), 1U);
    const PoseSample& sample = delivered.pose[0];
    const VehicleState truth = motion(to_seconds(now));
    EXPECT_EQ(sample.t, now);
    EXPECT_EQ(Vector3(sample.T_world_body.translation()), truth.p_world_m);
    EXPECT_NEAR((sample.T_world_body.linear() - truth.q_world_body.toRotationMatrix()).norm(), 0.0, 1e-15);
    EXPECT_EQ(sample.v_world_mps, truth.v_world_mps);
  });
}

TEST(Pose, ArrivesFirstTickAfterExactInstants) {
  PoseConfig config;
  config.rate_hz = 20.0;
  const auto sensor = make_pose_sensor(config, sensor_setup("pose"));
  std::vector<TimeNs> stamps, deliveries;
  const Motion motion = straight(Vector3::Zero(), Vector3(2.0, 0.0, 0.0));
  drive(*sensor, {motion}, {.duration_s = 0.3}, [&](TimeNs now, const Observation& delivered) {
    for (const PoseSample& sample : delivered.pose) {
      stamps.push_back(sample.t);
      deliveries.push_back(now);
      EXPECT_NEAR(sample.T_world_body.translation().x(), 2.0 * to_seconds(sample.t), 1e-12);
    }
  });
  constexpr TimeNs kMs = 1'000'000;
  EXPECT_EQ(stamps, (std::vector<TimeNs>{0, 50 * kMs, 100 * kMs, 150 * kMs, 200 * kMs, 250 * kMs, 300 * kMs}));
  EXPECT_EQ(deliveries,
            (std::vector<TimeNs>{4 * kMs, 52 * kMs, 100 * kMs, 152 * kMs, 200 * kMs, 252 * kMs, 300 * kMs}));
}

TEST(Pose, HasWhiteNoiseSigmaPerAxis) {
  PoseConfig config;
  config.sigma_position_m = {0.1, 0.2, 0.3};
  config.sigma_rotation_deg = {0.5, 1.0, 1.5};
  const auto sensor = make_pose_sensor(config, sensor_setup("pose"));
  const Observation seen = drive(*sensor, {resting({5.0, 6.0, 7.0}, 1.0)}, {.duration_s = 40.0});
  const Matrix3 R_body_world = state_at(Vector3::Zero(), 1.0).q_world_body.toRotationMatrix().transpose();
  for (int axis = 0; axis < 3; ++axis) {
    SampleStatistics position, rotation;
    for (const PoseSample& sample : seen.pose) {
      position.add(sample.T_world_body.translation()[axis] - Vector3(5.0, 6.0, 7.0)[axis]);
      const Eigen::Quaterniond error(Matrix3(R_body_world * sample.T_world_body.linear()));
      rotation.add(rotation_log(error)[axis] / kRadPerDeg);
    }
    const double v_position = std::pow(config.sigma_position_m[axis], 2);
    const double v_rotation = std::pow(config.sigma_rotation_deg[axis], 2);
    EXPECT_NEAR(position.mean(), 0.0, mean_bound(config.sigma_position_m[axis], position.size()));
    EXPECT_NEAR(position.variance(), v_position, variance_bound(v_position, position.size()));
    EXPECT_NEAR(rotation.variance(), v_rotation, variance_bound(v_rotation, rotation.size()));
  }
}

TEST(Pose, HasStatedCorrelatedSigmaAndDecay) {
  PoseConfig config;
  config.rate_hz = 10.0;
  config.sigma_position_m = {0.5, 0.5, 0.5};
  config.correlation_time_s = 1.0;
  SampleStatistics first, last, product;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const auto sensor = make_pose_sensor(config, sensor_setup("pose", seed));
    const Observation seen = drive(*sensor, {resting(Vector3::Zero())},
                                   {.duration_s = 1.0, .tick = 100'000'000, .step = 100'000'000, .capacity = 8});
    for (int axis = 0; axis < 3; ++axis) {
      const double a = seen.pose[0].T_world_body.translation()[axis];
      const double b = seen.pose[10].T_world_body.translation()[axis];  // 1 s later
      first.add(a);
      last.add(b);
      product.add(a * b);
    }
  }
  const double variance = 0.25;
  EXPECT_NEAR(first.variance(), variance, variance_bound(variance, first.size()));
  EXPECT_NEAR(last.variance(), variance, variance_bound(variance, last.size()));
  const double correlation = std::exp(-1.0);
  const double sigma_of_product = variance * std::sqrt(1.0 + correlation * correlation);
  EXPECT_NEAR(product.mean(), variance * correlation, mean_bound(sigma_of_product, product.size()));
}

}  // namespace
}  // namespace swiftlet::sim
