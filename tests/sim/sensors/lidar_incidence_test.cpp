// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/sim/sensors/lidar.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

constexpr std::uint64_t kLidarSeed = 7;

// A wall ahead, whose incidence is the angle of the beam. At steep incidence the cosine has little accuracy in single
// precision.
TEST(Lidar, IncidenceHasSinglePrecision) {
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
