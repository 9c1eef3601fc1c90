// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "swiftlet/sim/registry/sensors.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

TEST(SensorAllocations, AllocateNothingAfterWarmUp) {
  TestScene ground;
  ground.add_wall({-100, -100, 0}, {100, -100, 0}, {100, 100, 0}, {-100, 100, 0}, SurfaceClass::kGround);
  const auto world = std::make_shared<const StaticScene>(ground.scene());
  std::vector<std::unique_ptr<Sensor>> sensors;
  for (const ModuleType& type : sensor_module_types()) {
    const Module module(sensor_module_types(), type.name);
    if (std::string_view(type.name) != "lidar") {  // scans are held by their readers
      sensors.push_back(make_sensor(module, sensor_setup(type.name, 1, 3, world)));
    }
  }
  StateHistory history(3, 128);
  Observation observation;
  std::uint64_t before = 0;
  std::size_t num_samples = 0;
  for (int i = 0; i <= 2000; ++i) {
    if (i == 1000) before = test::num_allocations();
    const TimeNs now = static_cast<TimeNs>(i) * 4'000'000;
    for (VehicleId vehicle = 0; vehicle < 3; ++vehicle) {
      VehicleState state = state_at({3.0 * vehicle, 0.01 * i, 5.0});
      state.t = now;
      history.push(vehicle, state);
    }
    observation.clear();
    for (const auto& sensor : sensors) sensor->measure(now, history, observation);
    Observation::each_samples(observation, [&](const auto& samples) { num_samples += samples.size(); });
  }
  EXPECT_EQ(test::num_allocations(), before);
  EXPECT_GT(num_samples, 2000U);
}

}  // namespace
}  // namespace swiftlet::sim
