// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/imu.hpp"

#include <gtest/gtest.h>

#include <complex>

#include "sim/sensors/noise.hpp"
#include "tests/support/sample_statistics.hpp"
#include "tests/support/sensor_driver.hpp"

namespace swiftlet::sim {
namespace {

ImuConfig perfect_imu() {
  ImuConfig config;
  config.gyro_noise_density_radps_psqrthz = config.gyro_bias_walk_radps2_psqrthz = config.gyro_turn_on_bias_radps = 0.0;
  config.accel_noise_density_mps2_psqrthz = config.accel_bias_walk_mps3_psqrthz = config.accel_turn_on_bias_mps2 = 0.0;
  return config;
}

// A vehicle that banks, turns and weaves; velocities and rates are the exact derivatives.
VehicleState weaving_imu(double t) {
  VehicleState state;
  state.p_world_m = {3.0 * std::sin(t), 2.0 * std::cos(0.7 * t), 5.0 + 0.5 * std::sin(1.3 * t)};
  state.v_world_mps = {3.0 * std::cos(t), -1.4 * std::sin(0.7 * t), 0.65 * std::cos(1.3 * t)};
  const double yaw = 0.8 * t;
  const double roll = 0.4 * std::sin(2.0 * t);
  const double roll_rate = 0.8 * std::cos(2.0 * t);
  state.q_world_body = Eigen::AngleAxisd(yaw, Vector3::UnitZ()) * Eigen::AngleAxisd(roll, Vector3::UnitX());
  state.omega_body_radps = {roll_rate, 0.8 * std::sin(roll), 0.8 * std::cos(roll)};
  return state;
}

TEST(Imu, FeelsGravityUpwardsAtRest) {
  const auto sensor = make_imu_sensor(perfect_imu(), sensor_setup("imu"));
  const Observation seen = drive(*sensor, {resting({1.0, 2.0, 3.0}, 0.7)}, {});
  ASSERT_EQ(seen.imu.size(), 250U);
  for (const ImuSample& sample : seen.imu) {
    EXPECT_NEAR((sample.specific_force_body_mps2 - Vector3(0.0, 0.0, 9.81)).norm(), 0.0, 1e-12);
    EXPECT_NEAR(sample.omega_body_radps.norm(), 0.0, 1e-12);
  }
}

TEST(Imu, FeelsNothingInFreeFall) {
  const auto sensor = make_imu_sensor(perfect_imu(), sensor_setup("imu"));
  const Motion falling = [](double t) {
    VehicleState state = state_at({0.0, 0.0, 100.0 - 0.5 * 9.81 * t * t});
    state.v_world_mps.z() = -9.81 * t;
    return state;
  };
  for (const ImuSample& sample : drive(*sensor, {falling}, {}).imu) {
    EXPECT_NEAR(sample.specific_force_body_mps2.norm(), 0.0, 1e-9);
  }
}

/// Samples at this rate, integrated with the model of make_imu_sensor().
void expect_motion_given_back(double rate_hz) {
  ImuConfig config = perfect_imu();
  config.rate_hz = rate_hz;
  const auto sensor = make_imu_sensor(config, sensor_setup("imu"));
  const double duration_s = 4.0;
  // True states at the sensor's instants, because between states attitude and velocity are interpolated.
  const Observation seen =
      drive(*sensor, {weaving_imu}, {.duration_s = duration_s, .tick = 20'000'000, .step = 500'000});
  ASSERT_EQ(seen.imu.size(), static_cast<std::size_t>(std::lround(duration_s * rate_hz)));

  const double dt = 1.0 / rate_hz;
  VehicleState state = weaving_imu(0.0);
  for (const ImuSample& sample : seen.imu) {
    const Eigen::Quaterniond q_mid = state.q_world_body * rotation_exp(0.5 * dt * sample.omega_body_radps);
    const Vector3 a = q_mid * sample.specific_force_body_mps2 - Vector3(0.0, 0.0, 9.81);
    state.p_world_m += dt * state.v_world_mps + 0.5 * dt * dt * a;
    state.v_world_mps += dt * a;
    state.q_world_body = state.q_world_body * rotation_exp(dt * sample.omega_body_radps);
  }
  const VehicleState truth = weaving_imu(duration_s);
  EXPECT_LT((state.v_world_mps - truth.v_world_mps).norm(), 1e-9);
  EXPECT_LT(state.q_world_body.angularDistance(truth.q_world_body), 1e-9);
  // Second order: the error of the trapezoidal rule is dt^2 / 12 times the change of acceleration (about 6 m/s^2).
  EXPECT_LT((state.p_world_m - truth.p_world_m).norm(), dt * dt);
}

TEST(Imu, IntegratedSamplesGiveBackTheMotion) {
  for (const double rate_hz : {50.0, 100.0, 200.0, 250.0, 400.0}) {
    SCOPED_TRACE(rate_hz);
    expect_motion_given_back(rate_hz);
  }
}

TEST(Imu, MeasuresCentripetalAccelerationAtLeverArm) {
  ImuConfig config = perfect_imu();
  config.position_m = {0.2, 0.0, 0.1};
  const double rate = 3.0;
  const Motion spinning = [&](double t) {
    VehicleState state = state_at(Vector3::Zero(), rate * t);
    state.omega_body_radps.z() = rate;
    return state;
  };
  const auto sensor = make_imu_sensor(config, sensor_setup("imu"));
  for (const ImuSample& sample : drive(*sensor, {spinning}, {}).imu) {
    // The mean over an interval h is shorter by (rate h)^2 / 24.
    EXPECT_NEAR((sample.specific_force_body_mps2 - Vector3(-rate * rate * 0.2, 0.0, 9.81)).norm(), 0.0, 2e-5);
    EXPECT_NEAR((sample.omega_body_radps - Vector3(0.0, 0.0, rate)).norm(), 0.0, 1e-9);
  }
}

TEST(Imu, WhiteNoiseVarianceMatchesItsDensity) {
  ImuConfig config = perfect_imu();
  config.gyro_noise_density_radps_psqrthz = 3.39e-4;
  config.accel_noise_density_mps2_psqrthz = 4e-3;
  const auto sensor = make_imu_sensor(config, sensor_setup("imu"));
  const Observation seen = drive(*sensor, {resting(Vector3::Zero())}, {.duration_s = 40.0});
  SampleStatistics gyro, accel, product;
  for (std::size_t i = 0; i < seen.imu.size(); ++i) {
    gyro.add(seen.imu[i].omega_body_radps.x());
    accel.add(seen.imu[i].specific_force_body_mps2.z() - 9.81);
    if (i > 0) product.add(seen.imu[i].omega_body_radps.x() * seen.imu[i - 1].omega_body_radps.x());
  }
  const double gyro_variance = 3.39e-4 * 3.39e-4 * 250.0;
  const double accel_variance = 4e-3 * 4e-3 * 250.0;
  EXPECT_NEAR(gyro.variance(), gyro_variance, variance_bound(gyro_variance, gyro.size()));
  EXPECT_NEAR(accel.variance(), accel_variance, variance_bound(accel_variance, accel.size()));
  EXPECT_NEAR(product.mean(), 0.0, mean_bound(gyro_variance, product.size()));
}

/// Allan variance of samples at intervals of tau = `cluster` samples.
double allan_variance(const std::vector<double>& samples, std::size_t cluster) {
  SampleStatistics halves;
  double before = 0.0;
  for (std::size_t k = 0; k < samples.size() / cluster; ++k) {
    double mean = 0.0;
    for (std::size_t i = 0; i < cluster; ++i) mean += samples[k * cluster + i] / static_cast<double>(cluster);
    if (k > 0) halves.add(0.5 * (mean - before) * (mean - before));
    before = mean;
  }
  return halves.mean();
}

// IEEE Std 952: N / sqrt(tau) of white noise, K sqrt(tau / 3) of a random walk.
TEST(Imu, AllanDeviationMatchesTheDataSheet) {
  const auto deviation = [](const ImuConfig& config, double duration_s, double tau_s) {
    const auto sensor = make_imu_sensor(config, sensor_setup("imu"));
    const auto period = static_cast<TimeNs>(1e9 / config.rate_hz);
    const Observation seen = drive(*sensor, {resting(Vector3::Zero())},
                                   {.duration_s = duration_s, .tick = period, .step = period, .capacity = 8});
    const auto cluster = static_cast<std::size_t>(std::lround(tau_s * config.rate_hz));
    double variance = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> samples;
      samples.reserve(seen.imu.size());
      for (const ImuSample& sample : seen.imu) samples.push_back(sample.omega_body_radps[axis]);
      variance += allan_variance(samples, cluster) / 3.0;
    }
    return std::sqrt(variance);
  };
  ImuConfig white = perfect_imu();
  white.gyro_noise_density_radps_psqrthz = 3.39e-4;
  for (const double tau_s : {0.02, 0.1, 0.4})
    EXPECT_NEAR(deviation(white, 1600.0, tau_s) / (3.39e-4 / std::sqrt(tau_s)), 1.0, 0.02) << tau_s;
  ImuConfig walk = perfect_imu();
  walk.rate_hz = 50.0;
  walk.gyro_bias_walk_radps2_psqrthz = 3.88e-5;
  walk.gyro_bias_time_s = 1e6;
  for (const double tau_s : {1.0, 2.0})
    EXPECT_NEAR(deviation(walk, 8000.0, tau_s) / (3.88e-5 * std::sqrt(tau_s / 3.0)), 1.0, 0.02) << tau_s;
}

TEST(Imu, BiasFollowsAGaussMarkovProcess) {
  ImuConfig config = perfect_imu();
  config.rate_hz = 10.0;
  config.gyro_bias_walk_radps2_psqrthz = 0.01;
  config.gyro_bias_time_s = 2.0;
  SampleStatistics early, late;
  for (std::uint64_t seed = 0; seed < 700; ++seed) {
    const auto sensor = make_imu_sensor(config, sensor_setup("imu", seed));
    const Observation seen = drive(*sensor, {resting(Vector3::Zero())},
                                   {.duration_s = 6.0, .tick = 100'000'000, .step = 100'000'000, .capacity = 8});
    for (int axis = 0; axis < 3; ++axis) {
      early.add(seen.imu[4].omega_body_radps[axis]);  // t = 0.5 s
      late.add(seen.imu[59].omega_body_radps[axis]);  // t = 6 s
    }
  }
  const auto variance = [](double t) { return 1e-4 * 2.0 / 2.0 * (1.0 - std::exp(-2.0 * t / 2.0)); };
  EXPECT_NEAR(early.variance(), variance(0.5), variance_bound(variance(0.5), early.size()));
  EXPECT_NEAR(late.variance(), variance(6.0), variance_bound(variance(6.0), late.size()));
}

TEST(Imu, DrawsTurnOnBiasPerSeed) {
  ImuConfig config = perfect_imu();
  config.accel_turn_on_bias_mps2 = 0.196;
  SampleStatistics bias;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const auto sensor = make_imu_sensor(config, sensor_setup("imu", seed));
    const Observation seen = drive(*sensor, {resting(Vector3::Zero())}, {.duration_s = 0.012});
    ASSERT_EQ(seen.imu.size(), 3U);
    EXPECT_NEAR((seen.imu[0].specific_force_body_mps2 - seen.imu[2].specific_force_body_mps2).norm(), 0.0, 1e-12);
    for (int axis = 0; axis < 2; ++axis) bias.add(seen.imu[0].specific_force_body_mps2[axis]);
  }
  EXPECT_NEAR(bias.variance(), 0.196 * 0.196, variance_bound(0.196 * 0.196, bias.size()));
}

TEST(Imu, SaturatesInItsOwnAxes) {
  ImuConfig config = perfect_imu();
  config.gyro_max_radps = 8.0;
  const Motion spinning = [](double t) {
    VehicleState state;
    state.q_world_body = Eigen::AngleAxisd(10.0 * t, Vector3::UnitX());
    state.omega_body_radps.x() = 10.0;
    return state;
  };
  const auto aligned = make_imu_sensor(config, sensor_setup("imu"));
  EXPECT_NEAR(drive(*aligned, {spinning}, {}).imu.back().omega_body_radps.x(), 8.0, 1e-9);
  // Turned by 45 degrees, the two axes share the rate: 7.07 rad/s each is in range.
  config.rotation_rpy_deg.z() = 45.0;
  const auto turned = make_imu_sensor(config, sensor_setup("imu"));
  EXPECT_NEAR(drive(*turned, {spinning}, {}).imu.back().omega_body_radps.x(), 10.0, 1e-9);
}

TEST(Imu, MountErrorStaysInTheSample) {
  ImuConfig config = perfect_imu();
  config.rotation_rpy_deg.z() = 90.0;
  config.mount_error.rotation_deg = {0.0, 2.0, 0.0};  // the true y axis of the sensor is the body's -x axis
  const auto sensor = make_imu_sensor(config, sensor_setup("imu"));
  const Vector3 force = drive(*sensor, {resting(Vector3::Zero())}, {}).imu.back().specific_force_body_mps2;
  EXPECT_NEAR((force - 9.81 * Vector3(0.0, -std::sin(2.0 * kRadPerDeg), std::cos(2.0 * kRadPerDeg))).norm(), 0.0, 1e-9);
  // A lever arm of 0.1 m that the agent does not know of, in a turn of 3 rad/s.
  config = perfect_imu();
  config.mount_error.position_m = {0.1, 0.0, 0.0};
  const Motion spinning = [](double t) {
    VehicleState state = state_at(Vector3::Zero(), 3.0 * t);
    state.omega_body_radps.z() = 3.0;
    return state;
  };
  const auto displaced = make_imu_sensor(config, sensor_setup("imu"));
  EXPECT_NEAR(drive(*displaced, {spinning}, {}).imu.back().specific_force_body_mps2.x(), -0.9, 1e-4);
}

TEST(Imu, LosesSamplesAtStatedRate) {
  ImuConfig config = perfect_imu();
  config.dropout_probability = 0.1;
  config.outages = {{10.0, 12.0}};
  const auto sensor = make_imu_sensor(config, sensor_setup("imu"));
  const auto samples = drive(*sensor, {resting(Vector3::Zero())}, {.duration_s = 40.0}).imu;
  constexpr int kDue = 38 * 250;
  EXPECT_NEAR(static_cast<double>(samples.size()) / kDue, 0.9, share_bound(0.9, kDue));
  for (const ImuSample& sample : samples) EXPECT_TRUE(sample.t < 10 * kNsPerSecond || sample.t >= 12 * kNsPerSecond);
}

/// Amplitude of a tone in evenly spaced samples that last for many of its periods.
double amplitude_of(const std::vector<double>& samples, double rad_per_sample) {
  std::complex<double> sum = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i)
    sum += samples[i] * std::polar(1.0, -rad_per_sample * static_cast<double>(i));
  return 2.0 * std::abs(sum) / static_cast<double>(samples.size());
}

// A tone of amplitude A at rotor speed w is attenuated by sin(w h / 2) / (w h / 2) in means over h, and aliased.
TEST(Imu, VibrationFollowsTheRotorSpeed) {
  for (const double rate_hz : {100.0, 400.0}) {
    for (const double rotor_radps : {300.0, 600.0}) {
      ImuConfig config = perfect_imu();
      config.rate_hz = rate_hz;
      config.vibration = {.accel_mps2 = 2.0, .gyro_radps = 0.1, .rotor_speed_radps = 500.0};
      const Motion hovering = [&](double t) {
        VehicleState state = state_at({0, 0, 5});
        state.rotor_speed_radps[1] = rotor_radps;
        state.rotor_angle_rad[1] = -rotor_radps * t;
        return state;
      };
      const auto sensor = make_imu_sensor(config, sensor_setup("imu"));
      std::vector<double> x, z, rate_y;
      for (const ImuSample& sample : drive(*sensor, {hovering}, {.duration_s = 20.0, .tick = 20'000'000}).imu) {
        x.push_back(sample.specific_force_body_mps2.x());
        z.push_back(sample.specific_force_body_mps2.z() - 9.81);
        rate_y.push_back(sample.omega_body_radps.y());
      }
      const double growth = std::pow(rotor_radps / 500.0, 2), turn_rad = rotor_radps / rate_hz;
      const double attenuation = std::abs(std::sin(0.5 * turn_rad) / (0.5 * turn_rad));
      EXPECT_NEAR(amplitude_of(x, turn_rad), 2.0 * growth * attenuation, 0.01 * growth)
          << rate_hz << " " << rotor_radps;
      EXPECT_NEAR(amplitude_of(rate_y, turn_rad), 0.1 * growth * attenuation, 0.0005 * growth);
      EXPECT_NEAR(amplitude_of(z, 2.0 * turn_rad), 2.0 * growth * std::abs(std::sin(turn_rad) / turn_rad),
                  0.01 * growth);
    }
  }
}

TEST(Imu, CanBeFasterThanTheTick) {
  ImuConfig config = perfect_imu();
  config.rate_hz = 1000.0;
  const auto sensor = make_imu_sensor(config, sensor_setup("imu"));
  TimeNs expected = 0;
  drive(*sensor, {resting(Vector3::Zero())}, {}, [&](TimeNs now, const Observation& delivered) {
    ASSERT_EQ(delivered.imu.size(), 4U);
    for (const ImuSample& sample : delivered.imu) EXPECT_EQ(sample.t, expected += 1'000'000);
    EXPECT_EQ(expected, now);
  });
}

}  // namespace
}  // namespace swiftlet::sim
