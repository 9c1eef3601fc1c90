// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "swiftlet/sim/sensors/lidar.hpp"
#include "tests/support/sample_statistics.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kSigma_m = 0.01;

/// A LiDAR with white noise of 10 mm before a wall of reflectivity 0.3 that every beam meets.
LidarConfig lidar_at_wall() {
  LidarConfig config;
  config.mount.position_m.setZero();
  config.pattern = Module(lidar_pattern_types(), "uniform");
  config.pattern.as<UniformConfig>().fov_vertical_deg = 20.0;
  config.pattern.as<UniformConfig>().fov_horizontal_deg = 40.0;
  config.detection.always = true;
  config.noise.sigma_range_m = kSigma_m;
  return config;
}

std::vector<LabeledScan> scans_of(const LidarConfig& config, int num_scans = 1) {
  TestScene world;
  world.add_wall({10, -40, -40}, {10, 40, -40}, {10, 40, 40}, {10, -40, 40});
  SensorSetup setup = sensor_setup("lidar");
  setup.scene = std::make_shared<const Scene>(world.scene());
  setup.world = std::make_shared<const StaticScene>(*setup.scene);
  const auto sensor = make_lidar(config, setup);
  std::vector<LabeledScan> scans;
  drive(*sensor, {resting({0, 0, 0})}, {.duration_s = 0.1 * num_scans + 1e-6, .tick = 20'000'000},
        [&](TimeNs, const Observation&) {
          for (const auto& scan : sensor->scans()) scans.push_back(*scan);
        });
  return scans;
}

double tail_beyond(double deviations) { return std::erfc(deviations / std::numbers::sqrt2); }

TEST(LidarFaults, LosesShotsAtStatedRate) {
  LidarConfig config = lidar_at_wall();
  const Scan complete = scans_of(config)[0].scan;
  config.faults.dropout_probability = 0.02;
  const Scan scan = scans_of(config)[0].scan;
  int lost = 0;
  for (int i = 0; i < scan.size(); ++i) {
    lost += scan.hit(i) ? 0 : 1;
    EXPECT_TRUE(!scan.hit(i) || scan.range_m[i] == complete.range_m[i]) << "other shots are as without the fault";
  }
  EXPECT_NEAR(static_cast<double>(lost) / scan.size(), 0.02, share_bound(0.02, scan.size()));
}

TEST(LidarFaults, TailIsAMixtureOfNormals) {
  LidarConfig config = lidar_at_wall();
  config.faults.tail_probability = 0.03;
  config.faults.tail_factor = 8.0;
  const LabeledScan s = scans_of(config)[0];
  for (const double deviations : {2.0, 4.0, 8.0, 16.0}) {
    int beyond = 0;
    for (int i = 0; i < s.scan.size(); ++i)
      beyond += std::abs(s.scan.range_m[i] - s.truth.range_m[i]) > deviations * kSigma_m ? 1 : 0;
    const double p = 0.97 * tail_beyond(deviations) + 0.03 * tail_beyond(deviations / 8.0);
    EXPECT_NEAR(static_cast<double>(beyond) / s.scan.size(), p, share_bound(p, s.scan.size())) << deviations;
  }
}

TEST(LidarFaults, RangesAreWholeSteps) {
  LidarConfig config = lidar_at_wall();
  const Scan continuous = scans_of(config)[0].scan;
  config.faults.range_step_m = 0.008;
  const Scan stepped = scans_of(config)[0].scan;
  for (int i = 0; i < stepped.size(); ++i) {
    const double steps = static_cast<double>(stepped.range_m[i]) / 0.008;
    ASSERT_NEAR(steps, std::round(steps), 1e-3);
    ASSERT_NEAR(stepped.range_m[i], continuous.range_m[i], 0.0041);
  }
}

// u / (1 - u) = (x / c)^(1 / s) for the factor x of mean 1 and median c = sin(pi s) / (pi s).
TEST(LidarFaults, ReflectivityIsLogLogistic) {
  constexpr double kSpread = 0.3;
  LidarConfig config = lidar_at_wall();
  config.noise.sigma_range_m = 0.0;
  config.faults.reflectivity_spread = kSpread;
  const LabeledScan s = scans_of(config)[0];
  const double median = std::sin(std::numbers::pi * kSpread) / (std::numbers::pi * kSpread);
  double sum = 0.0;
  std::vector<int> below(3);
  const std::vector<double> places = {0.25, 1.0, 4.0};
  for (int i = 0; i < s.scan.size(); ++i) {
    const double uniform = 0.3 * std::cos(static_cast<double>(s.truth.incidence_rad[i]));
    const double factor = static_cast<double>(s.scan.reflectivity[i]) / uniform;
    sum += factor;
    for (std::size_t k = 0; k < places.size(); ++k) below[k] += factor < places[k] * median ? 1 : 0;
  }
  const int n = s.scan.size();
  // Variance of a log-logistic factor: c^2 / sinc(2 pi s) - 1, with c = sinc(pi s) as above.
  const double variance =
      median * median / (std::sin(2.0 * std::numbers::pi * kSpread) / (2.0 * std::numbers::pi * kSpread)) - 1.0;
  EXPECT_NEAR(sum / n, 1.0, mean_bound(std::sqrt(variance), n));
  for (std::size_t k = 0; k < places.size(); ++k) {
    const double odds = std::pow(places[k], 1.0 / kSpread), p = odds / (1.0 + odds);
    EXPECT_NEAR(static_cast<double>(below[k]) / n, p, share_bound(p, n) + 1.0 / 4096) << places[k];
  }
}

TEST(LidarFaults, WindowReturnsUndercutMinimumRange) {
  LidarConfig config = lidar_at_wall();
  config.faults.near_per_sweep = 11.6;
  config.faults.near_range_m = {0.099, 0.119};
  constexpr int kScans = 100;
  int near = 0;
  for (const LabeledScan& s : scans_of(config, kScans)) {
    for (int i = 0; i < s.scan.size(); ++i) {
      if (s.scan.range_m[i] > 1.0F) continue;
      ++near;
      EXPECT_GE(s.scan.range_m[i], 0.099F);
      EXPECT_LE(s.scan.range_m[i], 0.119F);
      EXPECT_EQ(s.truth.range_m[i], 0.0F) << "no surface of the scene";
    }
  }
  // 11 or 12 in each sweep; two of them rarely share a shot.
  EXPECT_NEAR(static_cast<double>(near) / kScans, 11.6, mean_bound(0.5, kScans) + 0.01);
}

TEST(LidarFaults, MasksMissTheRig) {
  LidarConfig config = lidar_at_wall();
  config.range_min_m = 0.1;
  config.self_mask = true;
  // A plate 1 m ahead that covers a tenth of the view's width, and one behind the wall.
  config.faults.rig = {{.center_m = {1.01, 0, 0}, .size_m = {0.02, 0.0728, 2}, .reflectivity = 0.2},
                       {.center_m = {12, 0, 0}, .size_m = {0.1, 20, 20}, .reflectivity = 0.2}};
  const LabeledScan s = scans_of(config)[0];
  int on_rig = 0;
  for (int i = 0; i < s.scan.size(); ++i) {
    const Eigen::Vector3f point = s.scan.point_lidar(i);
    if (s.scan.range_m[i] > 5.0F) continue;
    ++on_rig;
    EXPECT_NEAR(point.x(), 1.0, 1e-4);
    EXPECT_EQ(s.truth.surface_class[i], static_cast<int>(SurfaceClass::kVehicle));
    EXPECT_EQ(s.truth.instance[i], 1);
    EXPECT_EQ(s.scan.beams->masked[i], 0);
  }
  const double width_deg = 2.0 * std::atan(0.0364) * kDegPerRad;
  EXPECT_NEAR(static_cast<double>(on_rig) / s.scan.size(), width_deg / 40.0, 0.003);
}

TEST(LidarFaults, IdealSensorsHaveNone) {
  LidarConfig config = lidar_at_wall();
  config.ideal = true;
  config.faults = {.dropout_probability = 0.5,
                   .tail_probability = 0.5,
                   .range_step_m = 0.1,
                   .reflectivity_spread = 0.5,
                   .near_per_sweep = 100.0,
                   .rig = {{}}};
  const LabeledScan s = scans_of(config)[0];
  EXPECT_EQ(s.scan.range_m, s.truth.range_m);
}

}  // namespace
}  // namespace swiftlet::sim
