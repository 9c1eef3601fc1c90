// SPDX-License-Identifier: BSD-3-Clause
// Every return by its definition, written out plainly: rays through the static scene one by one, echoes that melt into
// one, noise from named streams of random numbers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

constexpr std::uint64_t kLidarSeed = 7;

/// Walls near and far, of any brightness, and poles, of which beams meet a part.
Scene bright_and_dark() {
  TestScene world;
  const std::uint32_t white = world.add_material(0.9F), black = world.add_material(0.02F),
                      tape = world.add_material(0.6F, true);
  world.add_wall({-90, -90, -3}, {90, -90, -3}, {90, 90, -3}, {-90, 90, -3}, SurfaceClass::kGround, 1);
  world.add_wall({12, -9, -3}, {9, 2, -3}, {9, 2, 5}, {12, -9, 5}, SurfaceClass::kWall, 2, white);
  world.add_wall({-45, -60, -3}, {-45, 60, -3}, {-45, 60, 30}, {-45, -60, 30}, SurfaceClass::kWall, 3, black);
  world.add_wall({1.5F, 12, -3}, {5, 11, -3}, {5, 11, 2}, {1.5F, 12, 2}, SurfaceClass::kMarking, 4, tape);
  world.add_wall({0.7F, -1, -1}, {0.7F, -0.4F, -1}, {0.7F, -0.4F, 1}, {0.7F, -1, 1}, SurfaceClass::kWall, 5, white);
  for (int k = 0; k < 12; ++k) {
    const float angle = 0.5F * static_cast<float>(k), r = 3.0F + static_cast<float>(k);
    const float x = r * std::cos(angle), y = r * std::sin(angle);
    world.add_box({x, y, -3}, {x + 0.03F, y + 0.03F, 4}, SurfaceClass::kObject, static_cast<std::uint16_t>(10 + k),
                  k % 3 == 0   ? white
                  : k % 3 == 1 ? black
                               : tape);
    world.add_box({x - 0.2F, y, 0}, {x + 0.3F, y + 0.02F, 0.05F}, SurfaceClass::kObject,
                  static_cast<std::uint16_t>(30 + k), white);
  }
  return world.scene();
}

struct Echo {
  double range_m = 0.0, cosine = 0.0, brightness = 0.0;
  RayHit surface;
};

/// A thin beam, or a Gaussian one by the points of its cubature: 3 x 3, or a center and a cross.
class PlainBeam {
 public:
  PlainBeam(const Scene& scene, const StaticScene& world, const LidarConfig& config)
      : scene_(scene), world_(world), config_(config) {
    const double a = std::sqrt(3.0) * config.beam.divergence_deg * kRadPerDeg / (2.0 * std::sqrt(2.0 * std::log(2.0)));
    const int count = config.ideal ? 1 : config.beam.sub_rays;
    for (int i = -1; i <= 1; ++i) {
      for (int j = -1; j <= 1; ++j) {
        const int off = std::abs(i) + std::abs(j);
        const double product = (i == 0 ? 2.0 / 3.0 : 1.0 / 6.0) * (j == 0 ? 2.0 / 3.0 : 1.0 / 6.0);
        const double weight = count == 9              ? product
                              : count == 5 && off < 2 ? (off == 0 ? 1.0 / 3.0 : 1.0 / 6.0)
                                                      : off == 0;
        if (weight > 0.0) points_.push_back({i * a, j * a, weight});
      }
    }
  }
  Echo trace(const Pose& T_world_lidar, const Vector3& direction_lidar, const Vector3& origin_lidar) const {
    std::vector<Echo> parts;
    for (const Vector3& point : points_) {
      Vector3 left = Vector3::UnitZ().cross(direction_lidar);
      left = left.norm() > 1e-6 ? Vector3(left.normalized()) : Vector3(Vector3::UnitY());
      const Vector3 up = direction_lidar.cross(left);
      const Vector3 way = (direction_lidar + point.x() * left + point.y() * up).normalized();
      const RayHit hit = world_.trace(T_world_lidar * origin_lidar, T_world_lidar.linear() * way, config_.range_max_m);
      if (hit.range_m <= 0.0F) continue;
      const Material& material = scene_.materials[hit.material];
      const double bright =
          material.reflectivity * (material.retroreflective ? config_.detection.retro_gain : double{hit.cos_incidence});
      parts.push_back({hit.range_m, hit.cos_incidence, point.z() * bright, hit});
    }
    Echo best;
    double strongest = 0.0;
    for (const Echo& first : parts) {
      Echo echo = first;
      double power = 0.0, moment = 0.0, brightest = 0.0;
      echo.brightness = 0.0;
      for (const Echo& part : parts) {
        if (part.range_m < first.range_m || part.range_m > first.range_m + config_.beam.pulse_length_m) continue;
        const double p = part.brightness / (part.range_m * part.range_m);
        power += p;
        moment += p * part.range_m;
        echo.brightness += part.brightness;
        if (p > brightest) brightest = p, echo.cosine = part.cosine, echo.surface = part.surface;
      }
      if (power <= strongest) continue;
      strongest = power;
      best = echo;
      best.range_m = moment / power;
    }
    return best;
  }

 private:
  const Scene& scene_;
  const StaticScene& world_;
  LidarConfig config_;
  std::vector<Vector3> points_;  // across, up, weight
};

struct Variant {
  const char* pattern;
  int sub_rays;
  bool ideal, rolling, always, by_signal;
};

class LidarDefinition : public ::testing::TestWithParam<Variant> {};
INSTANTIATE_TEST_SUITE_P(Variants, LidarDefinition,
                         ::testing::Values(Variant{"uniform", 1, false, true, false, false},
                                           Variant{"uniform", 5, false, false, false, true},
                                           Variant{"uniform", 9, false, true, true, true},
                                           Variant{"uniform", 9, true, false, false, false},
                                           Variant{"ouster", 5, false, true, false, false},
                                           Variant{"velodyne_puck", 1, false, false, false, true}));

TEST_P(LidarDefinition, ReturnsAreThoseOfPlainBeams) {
  const Variant variant = GetParam();
  LidarConfig config;
  config.pattern = Module(lidar_pattern_types(), variant.pattern);
  if (variant.pattern[0] == 'u') {
    config.pattern.as<UniformConfig>().rows = 15;
    config.pattern.as<UniformConfig>().columns = 167;
    config.pattern.as<UniformConfig>().fov_vertical_deg = 180.0;  // straight up and down as well
  } else if (variant.pattern[0] == 'o') {
    config.pattern.as<OusterConfig>().rows = 5;
    config.pattern.as<OusterConfig>().columns = 300;
    config.pattern.as<OusterConfig>().beam_origin_m = 0.1;
  }
  config.rate_hz = variant.pattern[0] == 'v' ? 100.0 : 10.0;
  config.rolling = variant.rolling;
  config.ideal = variant.ideal;
  config.range_min_m = 0.9;
  config.range_max_m = 60.0;
  config.mount.position_m = {0.1, 0.0, 0.2};
  config.mount.rpy_deg = {5.0, 10.0, 40.0};
  config.detection.always = variant.always;
  config.detection.range_10_percent_m = 15.0;
  config.detection.range_80_percent_m = 40.0;
  config.beam.sub_rays = variant.sub_rays;
  config.beam.divergence_deg = 0.5;
  config.beam.pulse_length_m = 0.4;
  config.noise.law = variant.by_signal ? RangeNoiseConfig::Law::kSignal : RangeNoiseConfig::Law::kConstant;
  SensorSetup setup = sensor_setup("s", kLidarSeed);
  setup.scene = std::make_shared<const Scene>(bright_and_dark());
  setup.world = std::make_shared<const StaticScene>(*setup.scene);
  const Motion motion = resting({0.3, 0.2, 0.1}, 0.6);
  const PlainBeam plain(*setup.scene, *setup.world, config);
  const auto sensor = make_lidar(config, setup);
  EXPECT_NEAR(sensor->look_back_s(), 1.0 / config.rate_hz, 1e-12);
  std::vector<std::shared_ptr<const LabeledScan>> scans;
  drive(*sensor, {motion}, {.duration_s = 2.0 / config.rate_hz + 1e-6, .tick = 10'000'000},
        [&](TimeNs, const Observation&) { scans.insert(scans.end(), sensor->scans().begin(), sensor->scans().end()); });
  ASSERT_EQ(scans.size(), 2U);

  const Pose T_world_lidar = motion(0.0).T_world_body() * config.mount.T_body_lidar();
  const LidarMeasurement measurement(config.noise, config.detection, config.range_max_m, config.ideal);
  const Random range_noise(kLidarSeed, "lidar.range", "uav1/s"), notice_noise(kLidarSeed, "lidar.detection", "uav1/s");
  int met = 0, lost = 0, apart = 0, blind = 0;
  for (std::uint32_t k = 0; k < 2; ++k) {
    const LabeledScan& labeled = *scans[k];
    const Scan& scan = labeled.scan;
    EXPECT_EQ(scan.sensor, "s");
    EXPECT_EQ(scan.range_max_m, 60.0);
    EXPECT_EQ(scan.sigma_range_m, config.ideal ? 0.0 : config.noise.sigma_range_m);
    EXPECT_EQ(labeled.truth.T_world_lidar.size(), variant.rolling ? static_cast<std::size_t>(scan.cols()) : 1U);
    for (const Pose& T : labeled.truth.T_world_lidar) EXPECT_LT((T.matrix() - T_world_lidar.matrix()).norm(), 1e-6);
    std::vector<float> noise(static_cast<std::size_t>(scan.size()));
    range_noise.fill_normal(k, 0, noise);
    for (int i = 0; i < scan.size(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Echo echo = plain.trace(T_world_lidar, scan.beams->directions_lidar[at].cast<double>(),
                                    scan.beams->origins_lidar[at].cast<double>());
      if (std::abs(labeled.truth.range_m[at] - echo.range_m) > 2e-4 * (1.0 + echo.range_m)) {
        ++apart;  // by an edge that rounding puts on either side of a ray
        continue;
      }
      const bool is_met = echo.range_m > 0.0;
      met += is_met;
      EXPECT_EQ(labeled.truth.instance[at], echo.surface.instance);
      EXPECT_EQ(labeled.truth.surface_class[at],
                static_cast<std::uint16_t>(is_met ? echo.surface.surface_class : SurfaceClass{}));
      EXPECT_EQ(labeled.truth.part[at], 0);
      EXPECT_NEAR(labeled.truth.incidence_rad[at], is_met ? std::acos(std::min(echo.cosine, 1.0)) : 0.0, 3e-3);
      float sigma = 0.0F, gain = 0.0F;
      measurement.look_up(static_cast<float>(echo.range_m), static_cast<float>(echo.cosine),
                          static_cast<float>(echo.brightness), sigma, gain);
      const double measured_m = std::min(echo.range_m + sigma * noise[at], 60.0);
      const double margin =
          echo.brightness * gain - measurement.threshold_snr() + notice_noise.normal(k, static_cast<std::uint32_t>(i));
      if (std::abs(margin) < 0.02 || std::abs(measured_m - 0.9) < 1e-4) continue;
      const bool noticed = is_met && measured_m >= 0.9 &&
                           measurement.noticed(static_cast<float>(echo.brightness * gain),
                                               [&] { return notice_noise.normal(k, static_cast<std::uint32_t>(i)); });
      lost += is_met && !noticed;
      blind += is_met && measured_m < 0.9;
      ASSERT_EQ(scan.hit(i), noticed) << i << " at " << echo.range_m;
      if (!noticed) {
        EXPECT_EQ(scan.intensity[at], 0.0F);
        EXPECT_EQ(scan.reflectivity[at], 0.0F);
        continue;
      }
      EXPECT_NEAR(scan.range_m[at], measured_m, 3e-4 * (1.0 + measured_m)) << i;
      const double intensity = echo.brightness * std::pow(10.0 / echo.range_m, 2);
      EXPECT_NEAR(scan.intensity[at], intensity, 2e-3 * intensity) << i;
      EXPECT_NEAR(scan.reflectivity[at], intensity * std::pow(measured_m / 10.0, 2),
                  2e-3 * intensity * std::pow(measured_m / 10.0, 2))
          << i;
    }
  }
  EXPECT_GT(met, 700);
  EXPECT_LT(apart, 0.02 * met) << met;
  if (!variant.always && !variant.ideal) {
    EXPECT_GT(lost, 50);
  }
  EXPECT_GT(blind, variant.pattern[0] == 'u' ? 5 : -1);
}

// A wall ahead, whose incidence is the angle of the beam. Where it is steep, its cosine says little in single
// precision.
TEST(Lidar, IncidenceIsTheArcCosineToTheLastDigitsOfAFloat) {
  TestScene world;
  world.add_wall({5, -900, -900}, {5, 900, -900}, {5, 900, 900}, {5, -900, 900});
  LidarConfig config;
  config.ideal = true;
  config.range_max_m = 800.0;
  config.mount.position_m.setZero();
  config.pattern = Module(lidar_pattern_types(), "uniform");
  config.pattern.as<UniformConfig>().rows = 9;
  config.pattern.as<UniformConfig>().columns = 701;
  config.pattern.as<UniformConfig>().fov_horizontal_deg = 178.0;
  SensorSetup setup = sensor_setup("s", kLidarSeed);
  setup.scene = std::make_shared<const Scene>(world.scene());
  setup.world = std::make_shared<const StaticScene>(*setup.scene);
  const auto sensor = make_lidar(config, setup);
  drive(*sensor, {resting({0, 0, 0})}, {.duration_s = 0.1 + 1e-6, .tick = 10'000'000}, [&](TimeNs, const Observation&) {
    for (const auto& s : sensor->scans()) {
      for (std::size_t i = 0; i < s->scan.range_m.size(); ++i) {
        const double angle = std::acos(static_cast<double>(s->scan.beams->directions_lidar[i].x()));
        if (angle > 1.5) continue;  // edge-on
        EXPECT_NEAR(s->truth.incidence_rad[i], angle, angle > 0.3 ? 2e-6 : 1e-3) << i;
      }
    }
  });
}

}  // namespace
}  // namespace swiftlet::sim
