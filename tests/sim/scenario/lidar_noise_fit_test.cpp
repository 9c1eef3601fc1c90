// SPDX-License-Identifier: BSD-3-Clause
// The range noise of the Ouster presets: the least-squares fit that gave its numbers, and the scatter that comes out.
#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/sim/scenario/scenario.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "tests/support/sample_statistics.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

constexpr float kTypicalBrightness = 0.3F;  // reflectivity * cos(incidence)

LidarConfig preset(const std::string& name) {
  Scenario scenario;
  read_config_text("vehicles: [{sensors: [{type: lidar, model: " + name + "}]}]", "flight.yaml",
                   [&](ConfigVisitor& v) { scenario.visit(v); });
  return scenario.vehicles.at(0).sensors.at(0).as<LidarConfig>();
}

LidarMeasurement measurement_of(const LidarConfig& lidar) {
  return {lidar.noise, lidar.detection, lidar.range_max_m, false};
}

/// A published standard deviation, with a tolerance of half of its last digit.
struct Stated {
  double place;  ///< range [m], or signal in the maker's units
  double sigma_mm, tolerance_mm;
};
const std::vector<Stated> kRecordedOs1 = {{4, 8, 0.5}, {8, 10, 0.5}, {15, 12, 0.5}, {30, 14, 0.5}};
const std::vector<Stated> kRecordedOs0 = {{2, 5, 0.5}, {10, 10, 0.5}};
const std::vector<Stated> kDataSheetOs1 = {{12, 100, 5}, {100, 30, 5}, {250, 15, 2.5}};

double sigma_mm(const RangeNoiseConfig& noise, double snr) {
  const double floor_m = noise.floor_m + noise.floor_rise_m * std::max(0.0, std::log10(noise.floor_snr / snr));
  return 1e3 * std::hypot(floor_m, noise.sigma_at_reference_m * std::pow(noise.reference_snr / snr, noise.exponent));
}

/// Logarithms of floor_m, floor_rise_m, reference_snr, exponent, and of the maker's signal by ours.
using Parameters = Eigen::Vector<double, 5>;

RangeNoiseConfig noise_of(const Parameters& p) {
  RangeNoiseConfig noise;
  noise.floor_m = std::exp(p[0]);
  noise.floor_rise_m = std::exp(p[1]);
  noise.reference_snr = std::exp(p[2]);
  noise.exponent = std::exp(p[3]);
  return noise;
}

Eigen::VectorXd residuals(const LidarMeasurement& os1, const Parameters& p) {
  const RangeNoiseConfig noise = noise_of(p);
  std::vector<double> all;
  all.reserve(kRecordedOs1.size() + kDataSheetOs1.size());
  const auto add = [&](const Stated& stated, double snr) {
    all.push_back(std::log(sigma_mm(noise, snr) / stated.sigma_mm) * stated.sigma_mm / stated.tolerance_mm);
  };
  for (const Stated& stated : kRecordedOs1)
    add(stated, static_cast<double>(os1.snr(static_cast<float>(stated.place), kTypicalBrightness)));
  for (const Stated& stated : kDataSheetOs1) add(stated, stated.place / std::exp(p[4]));
  return Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

/// Levenberg-Marquardt with differences.
Parameters fitted(const LidarMeasurement& os1, Parameters p) {
  double damping = 1e-2;
  for (int step = 0; step < 3000; ++step) {
    const Eigen::VectorXd r = residuals(os1, p);
    Eigen::MatrixXd J(r.size(), 5);
    for (int i = 0; i < 5; ++i) J.col(i) = (residuals(os1, p + 1e-6 * Parameters::Unit(i)) - r) / 1e-6;
    Eigen::Matrix<double, 5, 5> H = J.transpose() * J;
    H.diagonal() *= 1.0 + damping;
    const Parameters next = p - H.ldlt().solve(J.transpose() * r);
    const bool better = residuals(os1, next).squaredNorm() < r.squaredNorm();
    damping *= better ? 0.3 : 10.0;
    if (better) p = next;
  }
  return p;
}

TEST(LidarNoiseFit, MatchesLeastSquaresForOs1) {
  const LidarConfig lidar = preset("os1_128");
  const LidarMeasurement os1 = measurement_of(lidar);
  const Parameters start = Eigen::Map<const Parameters>(
      std::array{std::log(0.01), std::log(0.002), std::log(1.0), std::log(0.6), std::log(10.0)}.data());
  const Parameters p = fitted(os1, start);
  const RangeNoiseConfig best = noise_of(p);
  const double ours_by_makers = std::exp(p[4]);
  for (const Stated& s : kRecordedOs1) {
    const auto snr = static_cast<double>(os1.snr(static_cast<float>(s.place), kTypicalBrightness));
    EXPECT_NEAR(sigma_mm(lidar.noise, snr), s.sigma_mm, s.tolerance_mm) << s.place;
  }
  for (const Stated& s : kDataSheetOs1) {
    const double snr = s.place / ours_by_makers;
    EXPECT_NEAR(sigma_mm(lidar.noise, snr), s.sigma_mm, 1.5 * s.tolerance_mm) << s.place;
  }
  EXPECT_NEAR(lidar.noise.floor_m / best.floor_m, 1.0, 0.02);
  EXPECT_NEAR(lidar.noise.floor_rise_m / best.floor_rise_m, 1.0, 0.02);
  EXPECT_NEAR(lidar.noise.reference_snr / best.reference_snr, 1.0, 0.02);
  EXPECT_NEAR(lidar.noise.exponent / best.exponent, 1.0, 0.02);
}

TEST(LidarNoiseFit, SharesOs1LawWithFittedFloor) {
  const LidarConfig lidar = preset("os0_128");
  RangeNoiseConfig noise = preset("os1_128").noise;
  EXPECT_EQ(lidar.noise.floor_rise_m, noise.floor_rise_m);
  EXPECT_EQ(lidar.noise.reference_snr, noise.reference_snr);
  EXPECT_EQ(lidar.noise.exponent, noise.exponent);
  const LidarMeasurement os0 = measurement_of(lidar);
  const auto misfit = [&](double floor_m) {
    noise.floor_m = floor_m;
    double sum = 0.0;
    for (const Stated& s : kRecordedOs0) {
      const double snr = os0.snr(static_cast<float>(s.place), kTypicalBrightness);
      sum += std::pow(std::log(sigma_mm(noise, snr) / s.sigma_mm) * s.sigma_mm / s.tolerance_mm, 2);
    }
    return sum;
  };
  EXPECT_LT(misfit(lidar.noise.floor_m), misfit(1.02 * lidar.noise.floor_m));
  EXPECT_LT(misfit(lidar.noise.floor_m), misfit(0.98 * lidar.noise.floor_m));
}

/// Standard deviation of measured ranges on a wall of typical brightness across the view [mm].
double scatter_mm(const std::string& name, double range_m) {
  LidarConfig lidar = preset(name);
  lidar.mount = {};
  lidar.mount.position_m.setZero();
  const auto x = static_cast<float>(range_m);
  TestScene world;
  world.add_wall({x, -0.2F * x, -0.2F * x}, {x, 0.2F * x, -0.2F * x}, {x, 0.2F * x, 0.2F * x},
                 {x, -0.2F * x, 0.2F * x});
  SensorSetup setup = sensor_setup("lidar");
  setup.scene = std::make_shared<const Scene>(world.scene());
  setup.world = std::make_shared<const StaticScene>(*setup.scene);
  const auto sensor = make_lidar(lidar, setup);
  SampleStatistics error_mm;
  drive(*sensor, {resting({0, 0, 0})}, {.duration_s = 0.201, .tick = 10'000'000}, [&](TimeNs, const Observation&) {
    for (const auto& s : sensor->scans()) {
      for (int i = 0; i < s->scan.size(); ++i) {
        if (s->scan.hit(i) && s->truth.range_m[i] > 0.0F)
          error_mm.add(1e3 * static_cast<double>(s->scan.range_m[i] - s->truth.range_m[i]));
      }
    }
  });
  EXPECT_GT(error_mm.size(), 3000) << range_m;
  return std::sqrt(error_mm.variance());
}

TEST(LidarNoiseFit, MatchesRecordedScatterOfTypicalWalls) {
  // Bands are given in whole millimeters.
  constexpr double kHalfDigit_mm = 0.5;
  const auto in_band = [&](const char* name, double range_m, double least_mm, double most_mm) {
    const double measured_mm = scatter_mm(name, range_m);
    EXPECT_GE(measured_mm, least_mm - kHalfDigit_mm) << name << " " << range_m;
    EXPECT_LE(measured_mm, most_mm + kHalfDigit_mm) << name << " " << range_m;
  };
  for (const double range_m : {4.0, 6.0, 8.0}) in_band("os1_128", range_m, 8.0, 10.0);
  for (const double range_m : {15.0, 20.0, 25.0, 30.0}) in_band("os1_128", range_m, 12.0, 14.0);
  for (const double range_m : {2.0, 4.0, 6.0, 8.0, 10.0}) in_band("os0_128", range_m, 5.0, 10.0);
}

}  // namespace
}  // namespace swiftlet::sim
