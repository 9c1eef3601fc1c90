// SPDX-License-Identifier: BSD-3-Clause
// Retro-reflective markers of a vehicle in the scans of another one's LiDAR.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

constexpr float kThreshold = 3.0F;  // the default of relative_localization.marker_reflectivity

/// A vehicle of the size of an F330.
Airframe small_airframe() {
  Airframe airframe;
  airframe.arm_length_m = 0.165;
  airframe.body_height_m = 0.07;
  airframe.body_radius_m = 0.08;
  airframe.leg_height_m = 0.12;
  airframe.propeller_radius_m = 0.09;
  for (int i = 0; i < 4; ++i) {
    const double angle_rad = (0.25 + 0.5 * i) * kPi;
    airframe.rotors.push_back({Vector3(0.165 * std::cos(angle_rad), 0.165 * std::sin(angle_rad), 0.035),
                               i % 2 == 0 ? Rotor::Spin::kCcw : Rotor::Spin::kCw});
  }
  return airframe;
}

struct MarkerReturns {
  int marker = 0, hull = 0;
  float dimmest_marker = 1e9F, brightest_hull = 0.0F;
};

/// Returns of an OS0-128 from the vehicle at a distance, in `num_scans` sweeps while it turns and sways.
MarkerReturns look(double distance_m, const MarkersConfig& markers, int num_scans) {
  SensorSetup setup = sensor_setup("lidar", 1, 2);
  setup.scene = std::make_shared<const Scene>(TestScene().scene());
  setup.world = std::make_shared<const StaticScene>(*setup.scene);
  setup.vehicle_shapes[1] = std::make_shared<const VehicleShape>(make_vehicle_shape(small_airframe(), markers));
  LidarConfig config;
  config.mount.position_m.setZero();
  config.pattern = Module(lidar_pattern_types(), "uniform");
  config.pattern.as<UniformConfig>().rows = 128;
  config.pattern.as<UniformConfig>().columns = 1024;
  config.pattern.as<UniformConfig>().fov_vertical_deg = 90.0;
  const auto lidar = make_lidar(config, std::move(setup));
  const std::vector<Motion> motions = {resting({0, 0, 0}), [=](double t) {
                                         VehicleState state = state_at({distance_m, 0.3 * std::sin(7 * t), 0}, 2 * t);
                                         state.p_world_m.z() = 0.2 * std::sin(3 * t);
                                         return state;
                                       }};
  MarkerReturns returns;
  drive(*lidar, motions, {.duration_s = num_scans / config.rate_hz + 1e-6, .tick = 10'000'000},
        [&](TimeNs, const Observation&) {
          for (const auto& labeled : lidar->scans()) {
            for (int i = 0; i < labeled->scan.size(); ++i) {
              if (!labeled->scan.hit(i) || labeled->truth.instance[i] != 2) continue;
              const float reflectivity = labeled->scan.reflectivity[i];
              if (labeled->truth.part[i] == static_cast<int>(VehiclePart::kMarker)) {
                ++returns.marker;
                returns.dimmest_marker = std::min(returns.dimmest_marker, reflectivity);
              } else {
                ++returns.hull;
                returns.brightest_hull = std::max(returns.brightest_hull, reflectivity);
              }
            }
          }
        });
  return returns;
}

TEST(Markers, DifferFromHullByReflectivity) {
  for (const double distance_m : {2.0, 5.0, 10.0, 20.0}) {
    const MarkerReturns seen = look(distance_m, {.place = MarkersConfig::Place::kLegs}, 40);
    EXPECT_GT(seen.hull, 15) << distance_m;
    EXPECT_GT(seen.marker, 5) << distance_m;
    EXPECT_GT(seen.dimmest_marker, 2.0F * kThreshold) << distance_m;
    EXPECT_LT(seen.brightest_hull, 0.5F * kThreshold) << distance_m;
  }
}

TEST(Markers, AVehicleWithoutThemIsDark) {
  const MarkerReturns seen = look(5.0, {}, 10);
  EXPECT_GT(seen.hull, 50);
  EXPECT_EQ(seen.marker, 0);
  EXPECT_LT(seen.brightest_hull, 1.0F);
}

TEST(Markers, LargerOnesAreSeenMoreOften) {
  MarkersConfig small{.place = MarkersConfig::Place::kLegs, .length_m = 0.02}, large = small;
  large.length_m = 0.1;
  EXPECT_GT(look(5.0, large, 20).marker, 2 * look(5.0, small, 20).marker);
}

}  // namespace
}  // namespace swiftlet::sim
