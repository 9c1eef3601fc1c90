// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/localization/ins.hpp"

namespace swiftlet {
namespace {

using Index = InsFilter;
constexpr double kRadPerDegree = M_PI / 180.0;
const Vector3 kHover(0.0, 0.0, kGravity_mps2);

double variance(const InsFilter& filter, int i) { return filter.covariance()(i, i); }

/// A filter of a vehicle that hovers level at the origin.
InsFilter hovering_at(const InsConfig& config, TimeNs t, TimeNs first = 1) {
  InsFilter filter(config, Pose::Identity());
  filter.predict({first, Vector3::Zero(), kHover});
  if (t > first) filter.predict({t, Vector3::Zero(), kHover});
  return filter;
}

InsConfig only_start() {
  InsConfig config;
  config.gyro_noise_radps_sqrt_hz = config.gyro_walk_radps2_sqrt_hz = 0.0;
  config.accel_noise_mps2_sqrt_hz = config.accel_walk_mps3_sqrt_hz = 0.0;
  return config;
}

// Without noise the uncertainty of the start propagates by the laws of motion: a tilt accelerates by g sideways.
TEST(InsLaw, PropagatesInitialUncertaintyByMotionLaws) {
  const InsConfig config = only_start();
  const double dt = 0.05, g = kGravity_mps2, tilt = config.start_tilt_sigma_deg * kRadPerDegree;
  const InsFilter first = hovering_at(config, 1), next = hovering_at(config, 1 + from_seconds(dt));
  const double v0 = variance(first, Index::kV), a0 = variance(first, Index::kAccelBias),
               p0 = variance(first, Index::kP);
  EXPECT_NEAR(v0, std::pow(config.start_velocity_sigma_mps, 2), 1e-5);
  EXPECT_NEAR(a0, std::pow(config.start_accel_bias_sigma_mps2, 2), 1e-9);
  const double a_var = g * g * tilt * tilt + a0;
  for (const int axis : {0, 1}) {
    EXPECT_NEAR(variance(next, Index::kV + axis), v0 + dt * dt * a_var, 1e-4 * v0);
    EXPECT_NEAR(variance(next, Index::kP + axis), p0 + dt * dt * v0 + 0.25 * std::pow(dt, 4) * a_var, 1e-4 * p0);
  }
  EXPECT_NEAR(variance(next, Index::kV + 2), v0 + dt * dt * a0, 1e-4 * v0) << "a tilt does not lift";
  const double gyro = std::pow(config.start_gyro_bias_sigma_radps, 2);
  EXPECT_NEAR(variance(next, Index::kTheta), tilt * tilt + dt * dt * gyro, 1e-4 * tilt * tilt);
}

TEST(InsLaw, NoiseGrowsWithTheTime) {
  InsConfig config = only_start();
  config.accel_noise_mps2_sqrt_hz = 0.4;
  config.gyro_noise_radps_sqrt_hz = 0.05;
  config.accel_walk_mps3_sqrt_hz = 0.3;
  config.gyro_walk_radps2_sqrt_hz = 0.02;
  const double dt = 0.05;
  const TimeNs end = 1 + from_seconds(dt);
  const InsFilter quiet = hovering_at(only_start(), end), noisy = hovering_at(config, end);
  const InsFilter quiet_first = hovering_at(only_start(), 1), noisy_first = hovering_at(config, 1);
  const auto grown = [&](int i, int j) {
    return noisy.covariance()(i, j) - quiet.covariance()(i, j) -
           (noisy_first.covariance()(i, j) - quiet_first.covariance()(i, j));
  };
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(grown(Index::kV + axis, Index::kV + axis), 0.16 * dt, 1e-4);
    EXPECT_NEAR(grown(Index::kP + axis, Index::kP + axis), 0.16 * dt * dt * dt / 4.0, 2e-6);
    EXPECT_NEAR(grown(Index::kP + axis, Index::kV + axis), 0.16 * dt * dt / 2.0, 2e-5);
    EXPECT_NEAR(grown(Index::kTheta + axis, Index::kTheta + axis), 0.0025 * dt, 1e-6);
    EXPECT_NEAR(grown(Index::kAccelBias + axis, Index::kAccelBias + axis), 0.09 * dt, 1e-6);
    EXPECT_NEAR(grown(Index::kGyroBias + axis, Index::kGyroBias + axis), 0.0004 * dt, 1e-8);
  }
}

TEST(InsLaw, LosesTrustInAnImuGap) {
  const auto velocity_variance = [](double dt_s) {
    return variance(hovering_at(only_start(), 1 + from_seconds(dt_s)), Index::kV);
  };
  const double steady = velocity_variance(0.05), gap = velocity_variance(0.5);
  EXPECT_GT(gap, steady + 0.5) << "the motion in the gap is unknown";
}

TEST(InsLaw, WeighsPositionByItsVariance) {
  const InsConfig config = only_start();
  InsFilter filter = hovering_at(config, 1);
  const double own = variance(filter, Index::kP);
  GnssSample sample;
  sample.t = 1;
  sample.p_world_m = {0.05, -0.1, 0.2};
  sample.sigma_p_m = {0.1, 0.2, 0.4};
  sample.v_world_mps.setConstant(std::nan(""));
  filter.update(sample);
  for (int axis = 0; axis < 3; ++axis) {
    const double measured = std::pow(sample.sigma_p_m[axis], 2);
    EXPECT_NEAR(filter.state().p_m[axis], sample.p_world_m[axis] * own / (own + measured), 1e-4);
    EXPECT_NEAR(variance(filter, Index::kP + axis), own * measured / (own + measured), 1e-5);
  }
}

TEST(InsLaw, WeighsHeadingByVarianceAcrossWraparound) {
  const InsConfig config = only_start();
  for (const double yaw : {0.0, 3.1}) {
    InsFilter filter(config, make_pose(Vector3::Zero(), Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Vector3::UnitZ()))));
    filter.predict({1, Vector3::Zero(), kHover});
    const double own = std::pow(config.start_yaw_sigma_deg * kRadPerDegree, 2), measured = 0.03 * 0.03;
    filter.update(CompassSample{1, std::remainder(yaw + 0.06, 2.0 * M_PI), 0.03});
    const double turned = std::remainder(yaw_of(filter.state().q.toRotationMatrix()) - yaw, 2.0 * M_PI);
    EXPECT_NEAR(turned, 0.06 * own / (own + measured), 1e-4);
    EXPECT_NEAR(variance(filter, Index::kTheta + 2), own * measured / (own + measured), 1e-6);
  }
}

TEST(InsLaw, TakesOdometerVelocityInBodyFrame) {
  InsConfig config = only_start();
  config.odometry_velocity_sigma_mps = 0.001;
  InsFilter filter = hovering_at(config, 1);
  OdometrySample sample;
  sample.t = 1;
  sample.T_local_body = make_pose({9, 9, 9}, Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * M_PI, Vector3::UnitZ())));
  sample.v_local_body_mps = {0.0, 0.2, 0.1};  // along the body's x, independent of the odometer's frame
  filter.update(sample);
  EXPECT_NEAR(filter.state().v_mps.x(), 0.2, 0.005);
  EXPECT_NEAR(filter.state().v_mps.y(), 0.0, 0.005);
  EXPECT_NEAR(filter.state().v_mps.z(), 0.1, 0.005);
}

TEST(InsLaw, GrowsGroundVarianceWithDistanceFlown) {
  InsConfig config = only_start();
  config.ground_walk_m_sqrt_m = 0.5;
  InsFilter filter = hovering_at(config, 1);
  GnssSample fast;
  fast.t = 1;
  fast.p_world_m.setConstant(std::nan(""));
  fast.v_world_mps = {0.3, 0.4, 0.0};
  fast.sigma_v_mps.setConstant(1e-6);
  filter.update(fast);
  const double before = variance(filter, Index::kGround);
  filter.predict({1 + from_seconds(0.05), Vector3::Zero(), kHover});
  EXPECT_NEAR(variance(filter, Index::kGround) - before, 0.25 * 0.5 * 0.05, 1e-4);
}

}  // namespace
}  // namespace swiftlet
