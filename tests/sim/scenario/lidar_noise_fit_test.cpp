// SPDX-License-Identifier: BSD-3-Clause
// The range noise of the LiDAR presets: the least-squares fit of the Ousters' laws, and the scatter of all.
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

// reflectivity * cos(incidence) of typical returns, outdoors and indoors
constexpr float kOutdoors = 0.14F;
constexpr float kIndoors = 0.3F;

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
const std::vector<Stated> kRecordedOs1 = {{6, 8.5, 0.5}, {11.5, 8.5, 0.5}, {22, 11.3, 0.5}};
const std::vector<Stated> kRecordedOs0 = {{2, 5, 0.5}, {10, 10, 0.5}};
const std::vector<Stated> kDataSheetOs1 = {{12, 100, 5}, {100, 30, 5}, {250, 15, 2.5}};

double sigma_mm(const RangeNoiseConfig& noise, double snr) {
  const double floor_m = noise.floor_m + noise.floor_rise_m * std::max(0.0, std::log10(noise.floor_snr / snr));
  return 1e3 * std::hypot(floor_m, noise.sigma_at_reference_m * std::pow(noise.reference_snr / snr, noise.exponent));
}

/// Logarithms of floor_m, reference_snr, exponent, and of the maker's signal by ours. With a floor that rises as the
/// signal falls, the fit has a rise of 0.
using Parameters = Eigen::Vector<double, 4>;

RangeNoiseConfig noise_of(const Parameters& p) {
  RangeNoiseConfig noise;
  noise.floor_m = std::exp(p[0]);
  noise.floor_rise_m = 0.0;
  noise.reference_snr = std::exp(p[1]);
  noise.exponent = std::exp(p[2]);
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
    add(stated, static_cast<double>(os1.snr(static_cast<float>(stated.place), kOutdoors)));
  for (const Stated& stated : kDataSheetOs1) add(stated, stated.place / std::exp(p[3]));
  return Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

/// Levenberg-Marquardt with differences.
Parameters fitted(const LidarMeasurement& os1, Parameters p) {
  double damping = 1e-2;
  for (int step = 0; step < 3000; ++step) {
    const Eigen::VectorXd r = residuals(os1, p);
    Eigen::MatrixXd J(r.size(), 4);
    for (int i = 0; i < 4; ++i) J.col(i) = (residuals(os1, p + 1e-6 * Parameters::Unit(i)) - r) / 1e-6;
    Eigen::Matrix4d H = J.transpose() * J;
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
  const Parameters start =
      Eigen::Map<const Parameters>(std::array{std::log(0.01), std::log(1.0), std::log(0.6), std::log(10.0)}.data());
  const Parameters p = fitted(os1, start);
  const RangeNoiseConfig best = noise_of(p);
  const double ours_by_makers = std::exp(p[3]);
  for (const Stated& s : kRecordedOs1) {
    const auto snr = static_cast<double>(os1.snr(static_cast<float>(s.place), kOutdoors));
    EXPECT_NEAR(sigma_mm(lidar.noise, snr), s.sigma_mm, s.tolerance_mm) << s.place;
  }
  for (const Stated& s : kDataSheetOs1) {
    const double snr = s.place / ours_by_makers;
    EXPECT_NEAR(sigma_mm(lidar.noise, snr), s.sigma_mm, 1.5 * s.tolerance_mm) << s.place;
  }
  EXPECT_NEAR(lidar.noise.floor_m / best.floor_m, 1.0, 0.02);
  EXPECT_EQ(lidar.noise.floor_rise_m, 0.0);
  EXPECT_NEAR(lidar.noise.reference_snr / best.reference_snr, 1.0, 0.02);
  EXPECT_NEAR(lidar.noise.exponent / best.exponent, 1.0, 0.02);
}

TEST(LidarNoiseFit, Os0HasTheFittedFloor) {
  const LidarConfig lidar = preset("os0_128");
  RangeNoiseConfig noise = lidar.noise;
  const LidarMeasurement os0 = measurement_of(lidar);
  const auto misfit = [&](double floor_m) {
    noise.floor_m = floor_m;
    double sum = 0.0;
    for (const Stated& s : kRecordedOs0) {
      const double snr = os0.snr(static_cast<float>(s.place), kIndoors);
      sum += std::pow(std::log(sigma_mm(noise, snr) / s.sigma_mm) * s.sigma_mm / s.tolerance_mm, 2);
    }
    return sum;
  };
  EXPECT_LT(misfit(lidar.noise.floor_m), misfit(1.02 * lidar.noise.floor_m));
  EXPECT_LT(misfit(lidar.noise.floor_m), misfit(0.98 * lidar.noise.floor_m));
}

/// Standard deviation of measured ranges on a wall of this reflectivity across the view, without faults [mm].
double scatter_mm(const std::string& name, double range_m, float reflectivity) {
  LidarConfig lidar = preset(name);
  lidar.mount = {};
  lidar.faults = {};
  lidar.mount.position_m.setZero();
  const auto x = static_cast<float>(range_m);
  TestScene world;
  world.add_wall({x, -0.2F * x, -0.2F * x}, {x, 0.2F * x, -0.2F * x}, {x, 0.2F * x, 0.2F * x}, {x, -0.2F * x, 0.2F * x},
                 SurfaceClass::kWall, 0, world.add_material(reflectivity));
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
  EXPECT_GT(error_mm.size(), 300) << name << " " << range_m;
  return std::sqrt(error_mm.variance());
}

TEST(LidarNoiseFit, MatchesRecordedScatterOfTypicalWalls) {
  constexpr double kTolerance = 1.5;
  const auto matches = [&](const char* name, double range_m, float reflectivity, double recorded_mm) {
    const double measured_mm = scatter_mm(name, range_m, reflectivity);
    EXPECT_GE(measured_mm, recorded_mm / kTolerance) << name << " " << range_m;
    EXPECT_LE(measured_mm, recorded_mm * kTolerance) << name << " " << range_m;
  };
  for (const Stated& s : kRecordedOs1) matches("os1_128", s.place, kOutdoors, s.sigma_mm);
  for (const auto& [range_m, sigma_mm] : {std::pair{3.0, 5.7}, {6.0, 9.9}, {11.5, 8.5}})
    matches("os0_128", range_m, kIndoors, sigma_mm);
  for (const auto& [range_m, sigma_mm] : {std::pair{1.0, 4.6}, {3.0, 4.3}, {6.0, 5.0}, {11.5, 7.1}})
    matches("puck_lite", range_m, kIndoors, sigma_mm);
  for (const auto& [range_m, sigma_mm] : {std::pair{2.0, 6.0}, {11.5, 15.0}, {22.0, 19.0}, {45.0, 32.0}})
    matches("mid360", range_m, kOutdoors, sigma_mm);
}

TEST(LidarNoiseFit, SheetsHaveNoFaults) {
  for (const char* name : {"os1_128_sheet", "os0_128_sheet", "puck_lite_sheet", "mid360_sheet"}) {
    const LidarFaultsConfig faults = preset(name).faults;
    EXPECT_EQ(faults.dropout_probability, 0.0) << name;
    EXPECT_EQ(faults.tail_probability, 0.0) << name;
    EXPECT_EQ(faults.range_step_m, 0.0) << name;
    EXPECT_EQ(faults.reflectivity_spread, 0.0) << name;
    EXPECT_EQ(faults.near_per_sweep, 0.0) << name;
  }
}

}  // namespace
}  // namespace swiftlet::sim
