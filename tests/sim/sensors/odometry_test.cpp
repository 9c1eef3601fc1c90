// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/odometry.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "swiftlet/core/math/angles.hpp"
#include "tests/support/sample_statistics.hpp"
#include "tests/support/sensor_driver.hpp"

namespace swiftlet::sim {
namespace {

constexpr DriveOptions kSlowTick{.duration_s = 50.0, .tick = 100'000'000, .step = 100'000'000, .capacity = 8};

OdometryConfig perfect_odometry() {
  OdometryConfig config;
  config.rate_hz = 10.0;
  config.drift_percent = config.drift_per_turn_m = config.drift_m_psqrts = 0.0;
  config.yaw_drift_deg = config.yaw_drift_per_turn_deg = config.yaw_drift_deg_psqrts = 0.0;
  config.scale_error_percent = config.sigma_position_m = config.sigma_tilt_deg = config.sigma_velocity_mps = 0.0;
  return config;
}

VehicleState circling(double t) {
  const double rate = 0.5;
  VehicleState state =
      state_at({4.0 * std::cos(rate * t), 4.0 * std::sin(rate * t), 2.0 + 0.1 * t}, rate * t + std::numbers::pi / 2.0);
  state.v_world_mps = {-2.0 * std::sin(rate * t), 2.0 * std::cos(rate * t), 0.1};
  state.q_world_body = state.q_world_body * Eigen::AngleAxisd(0.2, Vector3::UnitX());  // banked
  return state;
}

// T_local_world that a sample implies, given the truth.
Pose frame_of(const OdometrySample& sample) {
  return sample.T_local_body * circling(to_seconds(sample.t)).T_world_body().inverse();
}

using Frame = OdometryConfig::Frame;

TEST(Odometry, KeepsItsFrameFixedWithoutErrors) {
  for (const Frame frame : {Frame::kStart, Frame::kWorld, Frame::kRandom}) {
    OdometryConfig config = perfect_odometry();
    config.frame = frame;
    const auto sensor = make_odometry_sensor(config, sensor_setup("vio"));
    const Observation seen = drive(*sensor, {circling}, kSlowTick);
    ASSERT_EQ(seen.odometry.size(), 501U);
    const Pose T_local_world = frame_of(seen.odometry[0]);
    EXPECT_NEAR(T_local_world.linear()(2, 2), 1.0, 1e-12) << "z stays up";
    for (const OdometrySample& sample : seen.odometry) {
      EXPECT_NEAR((frame_of(sample).matrix() - T_local_world.matrix()).norm(), 0.0, 1e-9) << static_cast<int>(frame);
      const Vector3 v_local = T_local_world.linear() * circling(to_seconds(sample.t)).v_world_mps;
      EXPECT_NEAR((sample.v_local_body_mps - v_local).norm(), 0.0, 1e-9);
    }
  }
}

TEST(Odometry, TheFrameStartsAsConfigured) {
  OdometryConfig config = perfect_odometry();
  const auto first = [&](std::uint64_t seed) {
    const auto sensor = make_odometry_sensor(config, sensor_setup("vio", seed));
    return drive(*sensor, {circling}, {.duration_s = 0.1}).odometry.at(0);
  };
  config.frame = OdometryConfig::Frame::kStart;
  EXPECT_NEAR(first(1).T_local_body.translation().norm(), 0.0, 1e-12);
  EXPECT_NEAR(yaw_of(first(1).T_local_body.linear()), 0.0, 1e-12);
  config.frame = OdometryConfig::Frame::kWorld;
  EXPECT_NEAR((frame_of(first(1)).matrix() - Eigen::Matrix4d::Identity()).norm(), 0.0, 1e-12);

  config.frame = OdometryConfig::Frame::kRandom;
  SampleStatistics x, yaw;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const OdometrySample sample = first(seed);
    EXPECT_LE(sample.T_local_body.translation().cwiseQuotient(Vector3(10.0, 10.0, 1.0)).cwiseAbs().maxCoeff(), 1.0);
    x.add(sample.T_local_body.translation().x());
    yaw.add(yaw_of(frame_of(sample).linear()));
  }
  // Uniform: variance of a third of the half-width squared; its estimate spreads by sqrt(0.8 / n).
  EXPECT_NEAR(x.variance(), 100.0 / 3.0, 5.0 * 100.0 / 3.0 * std::sqrt(0.8 / x.size()));
  const double v_yaw = std::numbers::pi * std::numbers::pi / 3.0;
  EXPECT_NEAR(yaw.variance(), v_yaw, 5.0 * v_yaw * std::sqrt(0.8 / yaw.size()));
}

TEST(Odometry, DistanceDriftMatchesTheStatedPercentage) {
  OdometryConfig config = perfect_odometry();
  config.drift_percent = 2.0;
  for (const double speed : {0.5, 2.0}) {
    const double length_m = speed * kSlowTick.duration_s;
    SampleStatistics along, up;
    double sum_sq = 0.0;
    for (std::uint64_t seed = 0; seed < 600; ++seed) {
      const auto sensor = make_odometry_sensor(config, sensor_setup("vio", seed));
      const Motion motion = straight(Vector3::Zero(), {speed, 0.0, 0.0});
      const Vector3 error =
          drive(*sensor, {motion}, kSlowTick).odometry.back().T_local_body.translation() - Vector3(length_m, 0.0, 0.0);
      along.add(error.x());
      up.add(error.z());
      sum_sq += error.squaredNorm();
    }
    // 2 % of 100 m is 2 m after 100 m; a random walk grows with the root of the length.
    const double variance = 4.0 * length_m / 100.0;
    EXPECT_NEAR(sum_sq / 600.0, variance, variance_bound(variance, 3 * 600));
    EXPECT_NEAR(along.variance(), variance / 3.0, variance_bound(variance / 3.0, along.size()));
    EXPECT_NEAR(up.variance(), variance / 3.0, variance_bound(variance / 3.0, up.size()));
  }
}

TEST(Odometry, YawDriftBendsThePathRandomly) {
  OdometryConfig config = perfect_odometry();
  config.yaw_drift_deg = 3.0;  // after 100 m
  const double length_m = 100.0;
  SampleStatistics yaw, lateral;
  for (std::uint64_t seed = 0; seed < 800; ++seed) {
    const auto sensor = make_odometry_sensor(config, sensor_setup("vio", seed));
    const Motion motion = straight(Vector3::Zero(), {2.0, 0.0, 0.0});
    const OdometrySample last = drive(*sensor, {motion}, kSlowTick).odometry.back();
    yaw.add(yaw_of(last.T_local_body.linear()));
    lateral.add(last.T_local_body.translation().y());
  }
  const double v_yaw = std::pow(3.0 * kRadPerDeg, 2);
  EXPECT_NEAR(yaw.variance(), v_yaw, variance_bound(v_yaw, yaw.size()));
  // Integrated Wiener process: q L^3 / 3 with q = v_yaw / L; 500 steps change it by 3 / (2 * 500).
  const double v_lateral = v_yaw * length_m * length_m / 3.0;
  EXPECT_NEAR(lateral.variance(), v_lateral, variance_bound(v_lateral, lateral.size()) + 0.003 * v_lateral);
}

TEST(Odometry, AddsDriftByTurningAndTime) {
  OdometryConfig config = perfect_odometry();
  config.yaw_drift_per_turn_deg = 1.0;
  config.yaw_drift_deg_psqrts = 0.1;
  config.drift_per_turn_m = 0.3;
  config.drift_m_psqrts = 0.02;
  const double turns = 4.0;
  const double rate = turns * 2.0 * std::numbers::pi / kSlowTick.duration_s;
  const Motion spinning = [&](double t) { return state_at(Vector3::Zero(), rate * t); };
  SampleStatistics yaw, x;
  for (std::uint64_t seed = 0; seed < 800; ++seed) {
    const auto sensor = make_odometry_sensor(config, sensor_setup("vio", seed));
    const OdometrySample last = drive(*sensor, {spinning}, kSlowTick).odometry.back();
    yaw.add(yaw_of(last.T_local_body.linear()));  // whole turns: back at zero
    x.add(last.T_local_body.translation().x());
  }
  const double v_yaw = (turns * 1.0 + 0.01 * kSlowTick.duration_s) * kRadPerDeg * kRadPerDeg;
  const double v_x = (turns * 0.09 + 4e-4 * kSlowTick.duration_s) / 3.0;
  EXPECT_NEAR(yaw.variance(), v_yaw, variance_bound(v_yaw, yaw.size()));
  EXPECT_NEAR(x.variance(), v_x, variance_bound(v_x, x.size()));
}

TEST(Odometry, ScaleAndTiltErrorsMatchSigmas) {
  OdometryConfig config = perfect_odometry();
  config.scale_error_percent = 1.0;
  config.sigma_tilt_deg = 0.5;
  config.sigma_velocity_mps = 0.05;
  config.sigma_position_m = 0.01;
  SampleStatistics scale, tilt, velocity;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const auto sensor = make_odometry_sensor(config, sensor_setup("vio", seed));
    const Motion motion = straight(Vector3::Zero(), {2.0, 0.0, 0.0});
    const OdometrySample last = drive(*sensor, {motion}, kSlowTick).odometry.back();
    scale.add(last.T_local_body.translation().x() / 100.0 - 1.0);
    tilt.add(std::asin(last.T_local_body.linear()(2, 1)));
    velocity.add(last.v_local_body_mps.y());
  }
  const double v_scale = 1e-4 + std::pow(0.01 / 100.0, 2);
  const double v_tilt = std::pow(0.5 * kRadPerDeg, 2);
  EXPECT_NEAR(scale.variance(), v_scale, variance_bound(v_scale, scale.size()));
  EXPECT_NEAR(tilt.variance(), v_tilt, variance_bound(v_tilt, tilt.size()));
  EXPECT_NEAR(velocity.variance(), 0.0025, variance_bound(0.0025, velocity.size()));
}

}  // namespace
}  // namespace swiftlet::sim
