// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/clocked_sensor.hpp"

#include <gtest/gtest.h>

#include "swiftlet/sim/sensors/imu.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"
#include "tests/support/sample_statistics.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

constexpr TimeNs kMillisecond = 1'000'000;

std::unique_ptr<Sensor> clocked_imu(const ImuConfig& config) {
  const SensorSetup setup = sensor_setup("imu");
  return with_clock(make_imu_sensor(config, setup), config, setup);
}

LidarConfig small_lidar() {
  LidarConfig config;
  config.mount.position_m.setZero();
  config.pattern = Module(lidar_pattern_types(), "uniform");
  config.pattern.as<UniformConfig>().rows = 2;
  config.pattern.as<UniformConfig>().columns = 16;
  return config;
}

std::unique_ptr<Sensor> clocked_lidar(const LidarConfig& config) {
  TestScene room;
  room.add_box({-8, -6, -3}, {9, 7, 4});
  SensorSetup setup = sensor_setup("lidar");
  setup.scene = std::make_shared<const Scene>(room.scene());
  setup.world = std::make_shared<const StaticScene>(*setup.scene);
  return with_clock(make_lidar(config, setup), config, setup);
}

TEST(Clock, IsExactByDefault) {
  const ImuConfig config;
  std::unique_ptr<Sensor> imu = make_imu_sensor(config, sensor_setup("imu"));
  const Sensor* const before = imu.get();
  EXPECT_EQ(with_clock(std::move(imu), config, sensor_setup("imu")).get(), before);
}

TEST(Clock, OffsetChangesStampsAlone) {
  ImuConfig config;
  const Motion motion = straight({0, 0, 5}, {1, 2, 0});
  const auto exact = drive(*clocked_imu(config), {motion}, {}).imu;
  config.clock.offset_s = 0.02;
  const auto late = drive(*clocked_imu(config), {motion}, {}).imu;
  ASSERT_EQ(late.size(), exact.size());
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_EQ(late[i].t, exact[i].t + 20 * kMillisecond);
    EXPECT_EQ(late[i].omega_body_radps, exact[i].omega_body_radps);
    EXPECT_EQ(late[i].specific_force_body_mps2, exact[i].specific_force_body_mps2);
  }
}

TEST(Clock, JitterHasItsDeviationInOrder) {
  ImuConfig config;
  config.clock = {.offset_s = 0.005, .jitter_s = 0.0005};
  SampleStatistics error_s, product;
  double previous_s = 0.0;
  const auto samples = drive(*clocked_imu(config), {resting({0, 0, 5})}, {.duration_s = 40.0}).imu;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double offset_s = to_seconds(samples[i].t) - 0.004 * (static_cast<double>(i) + 1.0) - 0.005;
    error_s.add(offset_s);
    product.add(offset_s * previous_s);
    previous_s = offset_s;
  }
  ASSERT_EQ(error_s.size(), 10000);
  EXPECT_NEAR(error_s.mean(), 0.0, mean_bound(0.0005, error_s.size()));
  EXPECT_NEAR(error_s.sigma(), 0.0005, variance_bound(0.0005, error_s.size()));
  EXPECT_NEAR(product.mean(), 0.0, mean_bound(0.0005 * 0.0005, product.size())) << "white";
  // A jitter of several intervals, and an offset that would begin before the start.
  config.clock = {.offset_s = -0.05, .jitter_s = 0.02};
  TimeNs last = -1;
  for (const ImuSample& sample : drive(*clocked_imu(config), {resting({0, 0, 5})}, {}).imu) {
    EXPECT_GT(sample.t, last);
    last = sample.t;
  }
}

TEST(Clock, LatencyDelaysNeighborsNotStamps) {
  NeighborsConfig config;
  config.sigma_bearing_deg = config.sigma_range_m = config.sigma_range_relative = config.dropout_probability = 0.0;
  config.range_max_m = 100.0;
  config.latency_s = 0.05;
  const SensorSetup setup = sensor_setup("neighbors", 1, 2);
  const auto sensor = with_clock(make_neighbors_sensor(config, setup), config, setup);
  EXPECT_EQ(sensor->look_back_s(), 0.05);
  std::vector<TimeNs> deliveries;
  const Motion other = straight({5.0, 0.0, 0.0}, {0.0, 3.0, 0.0});
  drive(*sensor, {resting(Vector3::Zero()), other}, {.duration_s = 0.3}, [&](TimeNs now, const Observation& delivered) {
    for (const NeighborSample& sample : delivered.neighbors) {
      EXPECT_EQ(sample.t, static_cast<TimeNs>(deliveries.size()) * 100 * kMillisecond);
      EXPECT_NEAR(sample.p_body_m.y(), 3.0 * to_seconds(sample.t), 1e-9);
      deliveries.push_back(now);
    }
  });
  EXPECT_EQ(deliveries, (std::vector<TimeNs>{52 * kMillisecond, 152 * kMillisecond, 252 * kMillisecond}));
}

TEST(Clock, TruthOfScansKeepsTrueTime) {
  LidarConfig config = small_lidar();
  const std::vector<Motion> motions = {straight({0, 0, 0}, {2, 1, 0})};
  const auto flown = [&] {
    std::vector<std::pair<TimeNs, LabeledScan>> scans;  // with their times of delivery
    const auto sensor = clocked_lidar(config);
    drive(*sensor, motions, {.duration_s = 0.45}, [&](TimeNs now, const Observation& delivered) {
      ASSERT_EQ(delivered.scans.size(), sensor->scans().size());
      for (const auto& scan : sensor->scans()) scans.emplace_back(now, *scan);
    });
    return scans;
  };
  const auto exact = flown();
  config.clock = {.offset_s = 0.1, .jitter_s = 0.002};  // a driver that stamps sweeps at their end
  config.latency_s = 0.03;
  const auto late = flown();
  ASSERT_EQ(exact.size(), 4U);
  ASSERT_EQ(late.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    const LabeledScan& scan = late[i].second;
    EXPECT_EQ(late[i].first, exact[i].first + 32 * kMillisecond) << "the next tick after the latency";
    EXPECT_EQ(scan.scan.stamp - scan.truth.clock_error, exact[i].second.scan.stamp);
    EXPECT_NEAR(to_seconds(scan.truth.clock_error), 0.1, 0.01);
    EXPECT_EQ(scan.scan.range_m, exact[i].second.scan.range_m);
    EXPECT_EQ(exact[i].second.truth.clock_error, 0);
  }
}

}  // namespace
}  // namespace swiftlet::sim
