// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/lidar_measurement.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/math/random.hpp"
#include "tests/support/sample_statistics.hpp"

namespace swiftlet::sim {
namespace {

TEST(LidarMeasurement, DetectsNinetyPercentAtDatasheetRanges) {
  for (const auto& [range_10, range_80] : {std::pair{40.0, 120.0}, std::pair{40.0, 70.0}, std::pair{18.3, 55.0}}) {
    DetectionConfig detection;
    detection.range_10_percent_m = range_10;
    detection.range_80_percent_m = range_80;
    const LidarMeasurement measurement({}, detection, 200.0, false);
    const auto probability = [&](double range_m, double reflectivity) {
      return measurement.detection_probability(
          measurement.snr(static_cast<float>(range_m), static_cast<float>(reflectivity)));
    };
    EXPECT_NEAR(probability(range_10, 0.1), 0.9, 2e-3);
    EXPECT_NEAR(probability(range_80, 0.8), 0.9, 2e-3);
    EXPECT_EQ(probability(0.5 * range_10, 0.1), 1.0);
    EXPECT_LT(probability(1.2 * range_10, 0.1), 0.75);
    EXPECT_LT(probability(2.0 * range_10, 0.1), 0.01);
  }
}

TEST(LidarMeasurement, DetectsWithStatedProbability) {
  const LidarMeasurement measurement({}, {}, 120.0, false);
  const Random random(1, "test.detection");
  constexpr int kDraws = 40000;
  for (const float range : {36.0F, 40.0F, 43.0F, 46.0F}) {
    const float snr = measurement.snr(range, 0.1F);
    int detected = 0;
    for (int i = 0; i < kDraws; ++i) detected += measurement.detected(snr, [&] { return random.normal(0, i); }) ? 1 : 0;
    const double p = measurement.detection_probability(snr);
    EXPECT_NEAR(static_cast<double>(detected) / kDraws, p, share_bound(p, kDraws) + 1e-5) << range;
  }
}

TEST(LidarMeasurement, SigmaFollowsTheTables) {
  RangeNoiseConfig noise;
  const LidarMeasurement constant(noise, {}, 120.0, false);
  EXPECT_FLOAT_EQ(constant.sigma_m(3.0F, 1.0F, 0.5F), 0.03F);
  EXPECT_FLOAT_EQ(constant.sigma_m(110.0F, 0.1F, 0.5F), 0.03F);
  noise.table_range_m = {10.0, 60.0};
  noise.table_sigma_m = {0.01, 0.06};
  noise.table_incidence_deg = {0.0, 60.0};
  noise.table_incidence_factor = {1.0, 3.0};
  const LidarMeasurement table(noise, {}, 120.0, false);
  EXPECT_NEAR(table.sigma_m(5.0F, 1.0F, 0.5F), 0.01, 1e-6);
  EXPECT_NEAR(table.sigma_m(35.0F, 1.0F, 0.5F), 0.035, 1e-5);
  EXPECT_NEAR(table.sigma_m(100.0F, 1.0F, 0.5F), 0.06, 1e-6);
  EXPECT_NEAR(table.sigma_m(35.0F, static_cast<float>(std::cos(0.523599)), 0.5F), 2.0 * 0.035, 2e-4);
  EXPECT_NEAR(table.sigma_m(35.0F, 0.3F, 0.5F), 3.0 * 0.035, 2e-4);
}

TEST(LidarMeasurement, SigmaBySignalFollowsDatasheetLaw) {
  RangeNoiseConfig noise;
  noise.law = RangeNoiseConfig::Law::kSignal;
  noise.floor_m = 0.0085;
  noise.floor_rise_m = 0.0;
  noise.reference_snr = 12.0;
  noise.exponent = 0.62;
  const LidarMeasurement by_signal(noise, {}, 120.0, false);
  const auto sigma_at = [&](double snr) {
    const float brightness = static_cast<float>(snr) / by_signal.snr(10.0F, 1.0F);
    return by_signal.sigma_m(10.0F, 1.0F, brightness);
  };
  // Data sheet of the OS1: 10 cm at 12, 3 cm at 100, 1.5 cm above 250.
  EXPECT_NEAR(sigma_at(12.0), 0.10, 0.001);
  EXPECT_NEAR(sigma_at(100.0), 0.03, 0.002);
  EXPECT_NEAR(sigma_at(320.0), 0.015, 0.0015);
  EXPECT_NEAR(sigma_at(1e6), 0.0085, 1e-4) << "no signal undercuts the floor";
  EXPECT_GT(sigma_at(1.0), 0.4);
  EXPECT_GT(by_signal.sigma_m(10.0F, 1.0F, 0.0F), 0.4F) << "without a signal it stays finite";
}

TEST(LidarMeasurement, FloorRisesAsSignalDropsTenfold) {
  RangeNoiseConfig noise;
  noise.law = RangeNoiseConfig::Law::kSignal;
  noise.floor_m = 0.008;
  noise.floor_rise_m = 0.003;
  noise.floor_snr = 1000.0;
  noise.sigma_at_reference_m = 0.0;
  const LidarMeasurement by_signal(noise, {}, 120.0, false);
  const auto sigma_at = [&](double snr) {
    return by_signal.sigma_m(10.0F, 1.0F, static_cast<float>(snr) / by_signal.snr(10.0F, 1.0F));
  };
  EXPECT_NEAR(sigma_at(1e5), 0.008, 1e-6);
  EXPECT_NEAR(sigma_at(1000.0), 0.008, 1e-4);
  EXPECT_NEAR(sigma_at(100.0), 0.011, 1e-5);
  EXPECT_NEAR(sigma_at(10.0), 0.014, 1e-5);
}

TEST(LidarMeasurement, IdealSensorSeesAllWithoutNoise) {
  const LidarMeasurement ideal({}, {}, 120.0, true);
  EXPECT_EQ(ideal.sigma_m(50.0F, 0.2F, 0.5F), 0.0F);
  EXPECT_TRUE(ideal.detected(ideal.snr(119.0F, 0.0F), [] { return -100.0; }));
}

}  // namespace
}  // namespace swiftlet::sim
