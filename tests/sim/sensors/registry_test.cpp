// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"
#include "swiftlet/sim/sensors/pose.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"
#include "tests/support/sensor_driver.hpp"

namespace swiftlet::sim {
namespace {

Module sensor_named(const std::string& type, const std::string& name = {}) {
  Module module(sensor_module_types(), type);
  dynamic_cast<SensorConfig&>(*module.config).name = name;
  return module;
}

TEST(SensorRegistry, TypesHaveDistinctNames) {
  std::set<std::string> names;
  for (const ModuleType& type : sensor_module_types()) EXPECT_TRUE(names.insert(type.name).second) << type.name;
  for (const char* name : {"pose", "imu", "gnss", "altimeter", "compass", "odometry", "neighbors"}) {
    EXPECT_TRUE(names.contains(name)) << name;
  }
}

TEST(SensorRegistry, AnUnknownTypeIsRefused) {
  Module module = sensor_named("pose");
  module.type = "sonar";
  EXPECT_THROW(make_sensor(module, sensor_setup("sonar")), std::invalid_argument);
}

TEST(SensorRegistry, NumbersUnnamedSensorsByType) {
  const std::vector<Module> sensors = {sensor_named("imu"), sensor_named("gnss"), sensor_named("imu"),
                                       sensor_named("pose", "imu2"), sensor_named("imu")};
  EXPECT_EQ(sensor_names(sensors), (std::vector<std::string>{"imu", "gnss", "imu3", "imu2", "imu4"}));
  const std::vector<Module> twice = {sensor_named("imu", "a"), sensor_named("gnss", "a")};
  EXPECT_THROW(sensor_names(twice), std::invalid_argument);
}

TEST(SensorRegistry, DerivesNumbersFromNameAndSeed) {
  PoseConfig config;
  config.sigma_position_m = {1.0, 1.0, 1.0};
  const auto positions = [&](SensorSetup setup, const std::vector<Motion>& motions) {
    std::vector<double> x;
    const auto sensor = make_pose_sensor(config, std::move(setup));
    for (const PoseSample& sample : drive(*sensor, motions, {.duration_s = 0.1}).pose) {
      x.push_back(sample.T_world_body.translation().x());
    }
    return x;
  };
  const Motion here = resting(Vector3::Zero());
  const auto alone = positions(sensor_setup("a"), {here});
  EXPECT_EQ(positions(sensor_setup("a", 1, 3), {here, here, here}), alone);
  EXPECT_NE(positions(sensor_setup("b"), {here}), alone);
  EXPECT_NE(positions(sensor_setup("a", 2), {here}), alone);
}

}  // namespace
}  // namespace swiftlet::sim
