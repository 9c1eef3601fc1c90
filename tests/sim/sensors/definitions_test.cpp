// SPDX-License-Identifier: BSD-3-Clause
// Every sample by its definition, written out plainly: the truth, and errors from named streams of random numbers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/sensors/altimeter.hpp"
#include "swiftlet/sim/sensors/compass.hpp"
#include "swiftlet/sim/sensors/gnss.hpp"
#include "swiftlet/sim/sensors/imu.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"
#include "swiftlet/sim/sensors/odometry.hpp"
#include "swiftlet/sim/sensors/pose.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

constexpr DriveOptions kTenths{.duration_s = 8.0, .tick = 100'000'000, .step = 100'000'000, .capacity = 16};
constexpr std::uint64_t kSeed = 12345678901234;

/// The streams of the sensor "s" of vehicle 1.
Random stream(const char* purpose) { return Random(kSeed, purpose, "uav1/s"); }
Vector3 normals(const Random& random, std::uint32_t index, std::uint32_t part = 0) {
  const auto n = random.normal3(index, part);
  return {n[0], n[1], n[2]};
}
Eigen::Quaterniond turned_by(const Vector3& rotation_vector) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(rotation_vector.norm(), rotation_vector.normalized()));
}
Eigen::Quaterniond turned_by_rpy(const Vector3& rpy_rad) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(rpy_rad.z(), Vector3::UnitZ())) *
         Eigen::AngleAxisd(rpy_rad.y(), Vector3::UnitY()) * Eigen::AngleAxisd(rpy_rad.x(), Vector3::UnitX());
}

/// A Gauss-Markov process that keeps its deviation.
struct Stationary {
  Vector3 sigma, value;
  double time_s;
  Stationary(const Vector3& sigma_of_axes, double correlation_time_s, const Vector3& first)
      : sigma(sigma_of_axes), value(sigma.cwiseProduct(first)), time_s(correlation_time_s) {}
  void go_on(double dt_s, const Vector3& n) {
    value = std::exp(-dt_s / time_s) * value + std::sqrt(1.0 - std::exp(-2.0 * dt_s / time_s)) * sigma.cwiseProduct(n);
  }
};

/// Banks, turns and weaves.
VehicleState weaving(double t) {
  VehicleState state;
  state.p_world_m = {3.0 * std::sin(t), 2.0 * std::cos(0.7 * t), 5.0 + 0.5 * std::sin(1.3 * t)};
  state.v_world_mps = {3.0 * std::cos(t), -1.4 * std::sin(0.7 * t), 0.65 * std::cos(1.3 * t)};
  state.q_world_body = turned_by_rpy({0.4 * std::sin(2.0 * t), 0.3 * std::cos(t), 0.8 * t});
  state.omega_body_radps = {0.3, -0.5 * std::cos(t), 0.7};
  return state;
}
double yaw_of_state(const VehicleState& state) {
  const Vector3 ahead = state.q_world_body * Vector3::UnitX();
  return std::atan2(ahead.y(), ahead.x());
}
double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

TEST(Definition, OfTheCompass) {
  CompassConfig config;
  config.rate_hz = 10.0;
  const auto sensor = make_compass_sensor(config, sensor_setup("s", kSeed));
  Stationary slow(Vector3(kRadPerDeg, 0.0, 0.0), 30.0, normals(stream("compass.disturbance.start"), 0));
  const auto seen = drive(*sensor, {weaving}, kTenths).compass;
  ASSERT_EQ(seen.size(), 81U);
  for (std::uint32_t i = 0; i < seen.size(); ++i) {
    if (i > 0) slow.go_on(0.1, normals(stream("compass.disturbance"), i));
    const double error_rad = 2.0 * kRadPerDeg * stream("compass.bias").normal(0, 0) + slow.value.x() +
                             kRadPerDeg * stream("compass.white").normal(i, 0);
    EXPECT_NEAR(wrapped(seen[i].yaw_rad - yaw_of_state(weaving(0.1 * i)) - error_rad), 0.0, 1e-9) << i;
  }
}

TEST(Definition, OfTheAltimeter) {
  TestScene ground;
  ground.add_wall({-100, -100, 0}, {100, -100, 0}, {100, 100, 0}, {-100, 100, 0});
  ground.add_box({-4, -4, 0}, {0, 0, 1});
  const auto world = std::make_shared<const StaticScene>(ground.scene());
  int told = 0;
  for (const auto beam : {AltimeterConfig::Beam::kVertical, AltimeterConfig::Beam::kBody}) {
    AltimeterConfig config;
    config.rate_hz = 10.0;
    config.beam = beam;
    config.position_m = {0.1, 0.2, -0.3};
    config.sigma_m = 0.05;
    config.sigma_relative = 0.03;
    config.range_min_m = 4.0;
    config.range_max_m = 5.2;
    const auto sensor = make_altimeter_sensor(config, sensor_setup("s", kSeed, 1, world));
    const auto seen = drive(*sensor, {weaving}, kTenths).altimeter;
    auto sample = seen.begin();
    for (std::uint32_t i = 0; i <= 80; ++i) {
      const VehicleState state = weaving(0.1 * i);
      const Vector3 from_m = state.p_world_m + state.q_world_body * config.position_m;
      const Vector3 down = beam == AltimeterConfig::Beam::kBody ? Vector3(state.q_world_body * -Vector3::UnitZ())
                                                                : Vector3(-Vector3::UnitZ());
      const double true_m = world->trace(from_m, down, 5.2).range_m;
      const double sigma_m = std::sqrt(0.05 * 0.05 + std::pow(0.03 * true_m, 2));
      const double range_m = true_m + sigma_m * stream("altimeter.range").normal(i, 0);
      if (true_m < 4.0 || range_m < 4.0 || range_m > 5.2) continue;
      ASSERT_NE(sample, seen.end());
      EXPECT_EQ(sample->t, 100'000'000LL * i);
      EXPECT_NEAR(sample->height_m, state.p_world_m.z() - (from_m + range_m * down).z(), 1e-9);
      EXPECT_NEAR(sample->sigma_m, -sigma_m * down.z(), 1e-9);
      ++sample;
      ++told;
    }
    EXPECT_EQ(sample, seen.end());
  }
  EXPECT_GT(told, 40);
  EXPECT_LT(told, 150);
}

TEST(Definition, OfThePose) {
  for (const double rate_hz : {0.0, 10.0}) {
    for (const double time_s : {0.0, 0.5}) {
      PoseConfig config;
      config.rate_hz = rate_hz;
      config.sigma_position_m = {0.1, 0.2, 0.3};
      config.sigma_rotation_deg = {1.0, 2.0, 3.0};
      config.sigma_velocity_mps = 0.4;
      config.sigma_rate_radps = 0.05;
      config.correlation_time_s = time_s;
      const auto sensor = make_pose_sensor(config, sensor_setup("s", kSeed));
      const auto seen = drive(*sensor, {weaving}, kTenths).pose;
      ASSERT_EQ(seen.size(), rate_hz == 0.0 ? 80U : 81U);
      const Vector3 sigma_rad = kRadPerDeg * Vector3(1.0, 2.0, 3.0);
      Stationary position(config.sigma_position_m, time_s, normals(stream("pose.position"), 0));
      Stationary rotation(sigma_rad, time_s, normals(stream("pose.rotation"), 0));
      for (std::uint32_t i = 0; i < seen.size(); ++i) {
        const VehicleState state = weaving(to_seconds(seen[i].t));
        if (time_s == 0.0) {
          position.value = position.sigma.cwiseProduct(normals(stream("pose.position"), i));
          rotation.value = rotation.sigma.cwiseProduct(normals(stream("pose.rotation"), i));
        } else if (i > 0) {
          position.go_on(0.1, normals(stream("pose.position"), i));
          rotation.go_on(0.1, normals(stream("pose.rotation"), i));
        }
        EXPECT_EQ(seen[i].t, 100'000'000LL * (rate_hz == 0.0 ? i + 1 : i));
        EXPECT_LT((seen[i].T_world_body.translation() - state.p_world_m - position.value).norm(), 1e-9);
        const Matrix3 R = (state.q_world_body * turned_by(rotation.value)).toRotationMatrix();
        EXPECT_LT((seen[i].T_world_body.linear() - R).norm(), 1e-9);
        EXPECT_LT((seen[i].v_world_mps - state.v_world_mps - 0.4 * normals(stream("pose.velocity"), i)).norm(), 1e-9);
        EXPECT_LT((seen[i].omega_body_radps - state.omega_body_radps - 0.05 * normals(stream("pose.rate"), i)).norm(),
                  1e-9);
      }
    }
  }
}

// Rates and forces are means over the interval, so that they integrate to the motion.
TEST(Definition, OfTheImu) {
  for (const double time_s : {0.0, 3.0}) {
    ImuConfig config;
    config.rate_hz = 10.0;
    config.position_m = {0.2, -0.1, 0.05};
    config.rotation_rpy_deg = {10.0, 20.0, 30.0};
    config.gyro_bias_time_s = config.accel_bias_time_s = time_s;
    config.gyro_bias_walk_radps2_psqrthz = 0.02;
    config.accel_bias_walk_mps3_psqrthz = 0.1;
    config.gyro_noise_density_radps_psqrthz = 0.01;
    config.accel_noise_density_mps2_psqrthz = 0.03;
    config.gyro_max_radps = 1.0;
    config.accel_max_mps2 = 10.0;
    config.gravity_mps2 = 9.7;
    const auto sensor = make_imu_sensor(config, sensor_setup("s", kSeed));
    EXPECT_NEAR(sensor->look_back_s(), 0.1, 1e-9);
    const auto seen = drive(*sensor, {weaving}, kTenths).imu;
    ASSERT_EQ(seen.size(), 80U);
    const Matrix3 R_body_imu = turned_by_rpy(kRadPerDeg * config.rotation_rpy_deg).toRotationMatrix();
    Vector3 gyro_bias = Vector3::Zero(), accel_bias = Vector3::Zero();
    const auto walk = [&](Vector3& bias, double density, const Vector3& n) {
      const double kept = time_s == 0.0 ? 1.0 : std::exp(-0.1 / time_s);
      bias = kept * bias + density * std::sqrt(time_s == 0.0 ? 0.1 : 0.5 * time_s * (1.0 - kept * kept)) * n;
    };
    const auto v_of_mount = [&](const VehicleState& state) -> Vector3 {
      return state.v_world_mps + state.q_world_body * state.omega_body_radps.cross(config.position_m);
    };
    for (std::uint32_t i = 0; i < seen.size(); ++i) {
      const VehicleState before = weaving(0.1 * i), after = weaving(0.1 * (i + 1));
      const Eigen::AngleAxisd turn(before.q_world_body.conjugate() * after.q_world_body);
      const Vector3 omega = turn.angle() / 0.1 * turn.axis();
      const Eigen::Quaterniond middle = before.q_world_body.slerp(0.5, after.q_world_body);
      const Vector3 a_world = (v_of_mount(after) - v_of_mount(before)) / 0.1;
      const Vector3 force = middle.conjugate() * (a_world + 9.7 * Vector3::UnitZ());
      walk(gyro_bias, 0.02, normals(stream("imu.gyro.bias"), i));
      walk(accel_bias, 0.1, normals(stream("imu.accel.bias"), i));
      const auto measured = [&](const Vector3& truth, const Vector3& turn_on, const Vector3& bias, double density,
                                const Random& white, double limit) -> Vector3 {
        const Vector3 sum =
            R_body_imu.transpose() * truth + turn_on + bias + density / std::sqrt(0.1) * normals(white, i);
        return R_body_imu * sum.cwiseMin(limit).cwiseMax(-limit);
      };
      EXPECT_EQ(seen[i].t, 100'000'000LL * (i + 1));
      EXPECT_LT((seen[i].omega_body_radps - measured(omega, 0.0087 * normals(stream("imu.gyro.turn_on"), 0), gyro_bias,
                                                     0.01, stream("imu.gyro"), 1.0))
                    .norm(),
                1e-8)
          << i;
      EXPECT_LT((seen[i].specific_force_body_mps2 - measured(force, 0.196 * normals(stream("imu.accel.turn_on"), 0),
                                                             accel_bias, 0.03, stream("imu.accel"), 10.0))
                    .norm(),
                1e-8)
          << i;
    }
  }
}

TEST(Definition, OfTheOdometry) {
  using Frame = OdometryConfig::Frame;
  for (const Frame frame : {Frame::kStart, Frame::kWorld, Frame::kRandom}) {
    OdometryConfig config;
    config.rate_hz = 10.0;
    config.frame = frame;
    config.initial_offset_m = {1.0, 2.0, 3.0};
    config.initial_yaw_deg = 70.0;
    config.drift_percent = 5.0;
    config.drift_m_psqrts = 0.05;
    config.yaw_drift_deg_psqrts = 0.7;
    config.scale_error_percent = 3.0;
    const auto sensor = make_odometry_sensor(config, sensor_setup("s", kSeed));
    const auto seen = drive(*sensor, {weaving}, kTenths).odometry;
    ASSERT_EQ(seen.size(), 81U);
    const double scale = 1.0 + 0.03 * stream("odometry.scale").normal(0, 0);
    Stationary tilt(0.2 * kRadPerDeg * Vector3(1.0, 1.0, 0.0), 5.0, normals(stream("odometry.tilt.start"), 0));
    Vector3 p_m = Vector3::Zero();
    double yaw_rad = 0.0;
    const VehicleState first = weaving(0.0);
    if (frame == Frame::kStart) yaw_rad = -yaw_of_state(first);
    if (frame == Frame::kWorld) p_m = first.p_world_m;
    if (frame == Frame::kRandom) {
      const Random random = stream("odometry.frame");
      yaw_rad = 70.0 * kRadPerDeg * (2.0 * random.uniform(0, 0) - 1.0);
      for (std::uint32_t a = 0; a < 3; ++a) p_m[a] = (a + 1.0) * (2.0 * random.uniform(0, 1 + a) - 1.0);
    }
    const auto R = [&] { return Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ()).toRotationMatrix(); };
    for (std::uint32_t i = 0; i < seen.size(); ++i) {
      const VehicleState state = weaving(0.1 * i);
      if (i > 0) {
        const VehicleState last = weaving(0.1 * (i - 1));
        const Vector3 step = state.p_world_m - last.p_world_m;
        const double turns = std::abs(wrapped(yaw_of_state(state) - yaw_of_state(last))) / (2.0 * std::numbers::pi);
        const double share = step.norm() / 100.0;  // of the reference path
        const double variance = share * std::pow(0.05 * 100.0, 2) + turns * 0.05 * 0.05 + 0.1 * 0.05 * 0.05;
        p_m += scale * (R() * step) + std::sqrt(variance / 3.0) * normals(stream("odometry.walk.position"), i);
        const double yaw_variance_deg2 = share * 1.0 + turns * 0.5 * 0.5 + 0.1 * 0.7 * 0.7;
        yaw_rad += kRadPerDeg * std::sqrt(yaw_variance_deg2) * stream("odometry.walk.yaw").normal(i, 0);
        tilt.go_on(0.1, normals(stream("odometry.tilt"), i));
      }
      const Vector3 told_m = p_m + 0.003 * normals(stream("odometry.position"), i);
      EXPECT_LT((seen[i].T_local_body.translation() - told_m).norm(), 1e-8) << i;
      const Matrix3 R_told = turned_by(tilt.value).toRotationMatrix() * R() * state.q_world_body.toRotationMatrix();
      EXPECT_LT((seen[i].T_local_body.linear() - R_told).norm(), 1e-8) << i;
      const Vector3 v = scale * (R() * state.v_world_mps) + 0.03 * normals(stream("odometry.velocity"), i);
      EXPECT_LT((seen[i].v_local_body_mps - v).norm(), 1e-8) << i;
    }
  }
}

/// Directions of satellites: equal areas of the sky above the mask, by the golden angle from a random azimuth on.
std::vector<Vector3> satellites(int count, double mask_deg) {
  std::vector<Vector3> directions;
  for (int i = 0; i < count; ++i) {
    const double lowest = std::sin(mask_deg * kRadPerDeg), z = lowest + (1.0 - lowest) * (i + 0.5) / count;
    const double azimuth = 2.0 * std::numbers::pi * stream("gnss.satellites").uniform(0, 0) +
                           i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    directions.emplace_back(std::sqrt(1.0 - z * z) * std::cos(azimuth), std::sqrt(1.0 - z * z) * std::sin(azimuth), z);
  }
  return directions;
}

TEST(Definition, OfGnss) {
  std::set<std::size_t> numbers;
  for (int variant = 0; variant < 6; ++variant) {
    GnssConfig config;
    config.rate_hz = 10.0;
    config.position_m = {0.1, 0.2, 0.3};
    config.drift_time_s = 3.0;
    config.altitude_walk_m_psqrts = 0.3;
    config.sigma_velocity_z_mps = 0.25;
    config.sky_view = variant > 0;
    config.num_satellites = 4 + variant;
    config.multipath_time_s = 2.0;
    if (variant % 2 == 1) config.outages = {{0.5, 0.7}, {2.0, 2.0}};
    if (variant % 2 == 0) config.random_outages_per_min = 60.0;
    config.random_outage_mean_s = 0.5;
    TestScene walls;
    walls.add_wall({1.0F, -9, 0}, {1.0F, 9, 0}, {1.0F, 9, 9}, {1.0F, -9, 9});
    walls.add_wall({-9, 0.5F, 0}, {9, 0.5F, 0}, {9, 0.5F, 9}, {-9, 0.5F, 9});
    const auto world = std::make_shared<const StaticScene>(walls.scene());
    const auto sensor = make_gnss_sensor(config, sensor_setup("s", kSeed, 1, world));
    const auto seen = drive(*sensor, {weaving}, kTenths).gnss;
    numbers.insert(seen.size());

    const Vector3 drift_sigma(1.5, 1.5, 2.0), white_sigma(0.3, 0.3, 0.5), velocity_sigma(0.1, 0.1, 0.25);
    Stationary drift(drift_sigma, 3.0, normals(stream("gnss.drift.start"), 0));
    Stationary multipath(Vector3::Ones(), 2.0, normals(stream("gnss.multipath.start"), 0));
    double altitude_m = 0.0;
    // Times with and without a fix in turn, each exponential.
    std::vector<TimeNs> changes;
    for (std::uint32_t k = 0; k < 100; ++k) {
      const double mean_s = k % 2 == 0 ? 1.0 : 0.5;
      const TimeNs lasts = from_seconds(-mean_s * std::log(1.0 - stream("gnss.outage").uniform(k, 0)));
      changes.push_back((changes.empty() ? 0 : changes.back()) + lasts);
    }
    auto sample = seen.begin();
    for (std::uint32_t i = 0; i <= 80; ++i) {
      const TimeNs t = 100'000'000LL * i;
      if (i > 0) {
        drift.go_on(0.1, normals(stream("gnss.drift"), i));
        multipath.go_on(0.1, normals(stream("gnss.multipath"), i));
        altitude_m += 0.3 * std::sqrt(0.1) * normals(stream("gnss.altitude"), i).z();
      }
      const VehicleState state = weaving(0.1 * i);
      const Vector3 antenna_m = state.p_world_m + state.q_world_body * config.position_m;
      int visible = config.num_satellites;
      if (config.sky_view) {
        for (const Vector3& d : satellites(config.num_satellites, 10.0)) {
          visible -= world->trace(antenna_m, d, 500.0).range_m > 0.0F;
        }
      }
      const auto past = std::count_if(changes.begin(), changes.end(), [&](TimeNs change) { return change <= t; });
      if (variant % 2 == 0 ? past % 2 == 1 : (t >= 500'000'000 && t < 700'000'000)) continue;
      if (visible < 4) continue;
      ASSERT_NE(sample, seen.end()) << variant;
      const double share = static_cast<double>(visible) / config.num_satellites, dilution = 1.0 / std::sqrt(share);
      const double path_sigma_m = 5.0 * (1.0 - share);
      const Vector3 error_m = dilution * (white_sigma.cwiseProduct(normals(stream("gnss.white"), i)) + drift.value) +
                              altitude_m * Vector3::Ones() + path_sigma_m * multipath.value;
      Vector3 expected_m = antenna_m + error_m;
      expected_m.head<2>() -= altitude_m * Eigen::Vector2d::Ones();
      EXPECT_EQ(sample->t, t);
      EXPECT_LT((sample->p_world_m - expected_m).norm(), 1e-8) << variant << " " << i;
      for (int a = 0; a < 3; ++a) {
        const double variance = dilution * dilution * (std::pow(white_sigma[a], 2) + std::pow(drift_sigma[a], 2)) +
                                path_sigma_m * path_sigma_m;
        EXPECT_NEAR(sample->sigma_p_m[a], std::sqrt(variance), 1e-9);
      }
      EXPECT_LT((sample->sigma_v_mps - dilution * velocity_sigma).norm(), 1e-9);
      const Vector3 v_mps = state.v_world_mps + state.q_world_body * state.omega_body_radps.cross(config.position_m) +
                            dilution * velocity_sigma.cwiseProduct(normals(stream("gnss.velocity"), i));
      EXPECT_LT((sample->v_world_mps - v_mps).norm(), 1e-8);
      ++sample;
    }
    EXPECT_EQ(sample, seen.end()) << variant;
  }
  EXPECT_GT(numbers.size(), 3U);
}

// A roof wide enough for the whole sky above the mask takes the fix at 80 m, and is no longer looked at at 520 m.
TEST(Definition, WhatIsFartherThan500MetersBlocksNoSatellite) {
  for (const float height_m : {80.0F, 520.0F}) {
    TestScene roof;
    roof.add_wall({-9e3F, -9e3F, height_m}, {9e3F, -9e3F, height_m}, {9e3F, 9e3F, height_m}, {-9e3F, 9e3F, height_m});
    GnssConfig config;
    config.sky_view = true;
    const auto world = std::make_shared<const StaticScene>(roof.scene());
    const auto sensor = make_gnss_sensor(config, sensor_setup("s", kSeed, 1, world));
    EXPECT_EQ(drive(*sensor, {resting(Vector3::Zero())}, kTenths).gnss.size(), height_m < 100.0F ? 0U : 41U);
  }
}

TEST(Definition, OfNeighbors) {
  TestScene wall;
  wall.add_box({4, 1, 0}, {5, 3, 9});
  const auto world = std::make_shared<const StaticScene>(wall.scene());
  int told = 0, swapped = 0;
  for (int variant = 0; variant < 4; ++variant) {
    NeighborsConfig config;
    config.rate_hz = 10.0;
    config.range_max_m = 11.0;
    config.range_min_m = 2.0;
    config.sigma_bearing_deg = 3.0;
    config.sigma_range_m = 0.2;
    config.sigma_range_relative = 0.1;
    config.dropout_probability = 0.2;
    config.id_swap_probability = 0.3;
    config.occluder_scale = 0.9;
    config.elevation_min_deg = -25.0;
    config.elevation_max_deg = 35.0;
    config.occlusion = variant != 1;
    config.ideal = variant == 3;
    if (variant == 2)
      config.cameras = {{.yaw_deg = 50.0, .pitch_deg = 20.0, .fov_deg = 100.0},
                        {.yaw_deg = -120.0, .pitch_deg = -10.0, .fov_deg = 70.0}};
    std::vector<Motion> motions = {weaving};
    for (int k = 1; k < 6; ++k) {
      motions.push_back([k](double t) {
        return state_at(
            {(2.0 + 2.0 * k) * std::cos(0.4 * t + k), (2.0 + k) * std::sin(0.3 * t * k), 5.0 + std::sin(t + k)});
      });
    }
    SensorSetup setup = sensor_setup("s", kSeed, 6, world);
    const auto radius_m = static_cast<double>(setup.vehicle_shapes[1]->circumscribed_radius_m);
    const auto sensor = make_neighbors_sensor(config, std::move(setup));
    const auto seen = drive(*sensor, motions, kTenths).neighbors;
    auto sample = seen.begin();
    for (std::uint32_t i = 0; i <= 80; ++i) {
      std::vector<VehicleState> states;
      for (const Motion& motion : motions) states.push_back(motion(0.1 * i));
      const VehicleState& self = states[0];
      std::vector<NeighborSample> expected;
      for (VehicleId k = 1; k < 6; ++k) {
        const std::string pair = "uav1/s/uav" + std::to_string(k + 1);
        const Vector3 p_m = self.q_world_body.conjugate() * (states[k].p_world_m - self.p_world_m);
        const double range_m = p_m.norm();
        if (config.ideal) {
          expected.push_back({100'000'000LL * i, k, p_m, 1e-6 * Matrix3::Identity()});
          continue;
        }
        bool in_view = range_m >= 2.0 && range_m <= 11.0;
        const double elevation_deg = std::asin(p_m.z() / range_m) * kDegPerRad;
        if (config.cameras.empty()) in_view = in_view && elevation_deg >= -25.0 && elevation_deg <= 35.0;
        bool in_camera = config.cameras.empty();
        for (const NeighborCamera& camera : config.cameras) {
          const double yaw = camera.yaw_deg * kRadPerDeg, pitch = camera.pitch_deg * kRadPerDeg;
          const Vector3 axis(std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), std::sin(pitch));
          in_camera = in_camera || std::acos(axis.dot(p_m) / range_m) * kDegPerRad <= 0.5 * camera.fov_deg;
        }
        bool hidden = world->trace(self.p_world_m, self.q_world_body * p_m / range_m, range_m).range_m > 0.0F;
        for (VehicleId third = 1; third < 6; ++third) {
          // The nearest place of the line of sight, by many.
          double nearest_m = 1e9;
          for (int s = 0; s <= 2000 && third != k; ++s) {
            const Vector3 at_m = self.p_world_m + s / 2000.0 * (states[k].p_world_m - self.p_world_m);
            nearest_m = std::min(nearest_m, (at_m - states[third].p_world_m).norm());
          }
          hidden = hidden || nearest_m < 0.9 * radius_m;
        }
        if (!in_view || !in_camera || (config.occlusion && hidden)) continue;
        if (Random(kSeed, "neighbors.dropout", pair).uniform(i, 0) < 0.2) continue;
        const auto sigma_m = [](double r_m) { return std::sqrt(0.04 + 0.01 * r_m * r_m); };
        const Vector3 n = normals(Random(kSeed, "neighbors.noise", pair), i), bearing = p_m / range_m;
        const Vector3 across = bearing.unitOrthogonal();
        const Vector3 turn = 3.0 * kRadPerDeg * (n.x() * across + n.y() * bearing.cross(across));
        const double told_m = std::max(range_m + sigma_m(range_m) * n.z(), 0.0);
        const Vector3 seen_along = turned_by(turn) * bearing;
        const Matrix3 along = seen_along * seen_along.transpose(), beside = Matrix3::Identity() - along;
        expected.push_back({100'000'000LL * i, k, told_m * seen_along,
                            std::pow(sigma_m(told_m), 2) * along + std::pow(3.0 * kRadPerDeg * told_m, 2) * beside});
      }
      for (std::size_t k = 0; k < expected.size() && expected.size() > 1 && !config.ideal; ++k) {
        if (Random(kSeed, "neighbors.swap", "uav1/s").uniform(i, static_cast<std::uint32_t>(k)) >= 0.3) continue;
        std::swap(expected[k].id, expected[(k + 1) % expected.size()].id);
        ++swapped;
      }
      for (const NeighborSample& e : expected) {
        ASSERT_NE(sample, seen.end()) << variant << " " << i;
        EXPECT_EQ(sample->t, e.t);
        EXPECT_EQ(sample->id, e.id) << variant << " " << i;
        EXPECT_LT((sample->p_body_m - e.p_body_m).norm(), 1e-8) << variant << " " << i;
        EXPECT_LT((sample->covariance_body - e.covariance_body).norm(), 1e-8) << variant << " " << i;
        ++sample;
        ++told;
      }
    }
    EXPECT_EQ(sample, seen.end()) << variant;
  }
  EXPECT_GT(told, 600);
  EXPECT_GT(swapped, 50);
}

TEST(Definition, OfPosesFromOutside) {
  for (const double time_s : {0.0, 0.2}) {
    for (const double spacing_s : {0.05, 0.033, 5.0}) {
      for (const bool rolling : {true, false}) {
        LidarConfig config;
        config.pattern = Module(lidar_pattern_types(), "uniform");
        config.pattern.as<UniformConfig>().rows = 1;
        config.pattern.as<UniformConfig>().columns = 4;
        config.rolling = rolling;
        config.mount.position_m = {0.1, 0.2, 0.3};
        config.mount.rpy_deg = {10.0, 20.0, 30.0};
        config.external_pose.enabled = true;
        config.external_pose.sigma_position_m = 0.2;
        config.external_pose.sigma_rotation_rad = 0.1;
        config.external_pose.correlation_time_s = time_s;
        config.external_pose.spacing_s = spacing_s;
        const auto sensor = make_lidar(config, sensor_setup("s", kSeed));
        const Random random_p = stream("lidar.pose.position"), random_R = stream("lidar.pose.rotation");
        Stationary t_n(Vector3::Constant(0.2), time_s, normals(random_p, 0));
        Stationary rpy_n(Vector3::Constant(0.1), time_s, normals(random_R, 0));
        Pose T_body_lidar = Pose::Identity();
        T_body_lidar.translation() = config.mount.position_m;
        T_body_lidar.linear() = turned_by_rpy(kRadPerDeg * config.mount.rpy_deg).toRotationMatrix();
        TimeNs last = -1;
        std::uint32_t sweep = 0;
        drive(*sensor, {weaving}, {.duration_s = 1.0, .tick = 10'000'000}, [&](TimeNs now, const Observation& seen) {
          for (const auto& scan : seen.scans) {
            const auto& told = scan->external_poses;
            ASSERT_EQ(told.size(), !rolling ? 1U : spacing_s == 0.05 ? 3U : spacing_s == 0.033 ? 4U : 2U);
            for (std::uint32_t k = 0; k < told.size(); ++k) {
              const TimeNs t = rolling ? now - 100'000'000 + 100'000'000 * k / (told.size() - 1) : now;
              EXPECT_EQ(told[k].t, t);
              if (time_s == 0.0) {
                t_n.value = 0.2 * normals(random_p, sweep);
                rpy_n.value = 0.1 * normals(random_R, sweep);
              } else if (last >= 0) {
                t_n.go_on(to_seconds(t - last), normals(random_p, sweep, k));
                rpy_n.go_on(to_seconds(t - last), normals(random_R, sweep, k));
              }
              last = t;
              const VehicleState state = weaving(to_seconds(t));
              const Pose truth = make_pose(state.p_world_m, state.q_world_body) * T_body_lidar;
              const Pose ours = told[k].T_world_body * T_body_lidar;
              EXPECT_LT((ours.translation() + t_n.value - truth.translation()).norm(), 1e-4) << sweep << " " << k;
              EXPECT_LT((ours.linear() * turned_by_rpy(rpy_n.value).toRotationMatrix() - truth.linear()).norm(), 1e-4);
            }
            ++sweep;
          }
        });
        EXPECT_EQ(sweep, 10U);
      }
    }
  }
}

}  // namespace
}  // namespace swiftlet::sim
