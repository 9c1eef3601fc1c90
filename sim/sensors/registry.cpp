// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <stdexcept>

#include "sim/sensors/altimeter.hpp"
#include "sim/sensors/compass.hpp"
#include "sim/sensors/gnss.hpp"
#include "sim/sensors/imu.hpp"
#include "sim/sensors/lidar.hpp"
#include "sim/sensors/neighbors.hpp"
#include "sim/sensors/odometry.hpp"
#include "sim/sensors/pose.hpp"
#include "sim/sensors/sensor.hpp"

namespace swiftlet::sim {
namespace {

// What exists: adding a sensor is one line here.
constexpr SensorType kSensorTypes[] = {
    {{"pose", "pose from outside: motion capture, RTK, or the truth itself", make_module_config<PoseConfig>},
     make_pose_sensor},
    {{"imu", "rates and specific force, with bias and noise", make_module_config<ImuConfig>}, make_imu_sensor},
    {{"gnss", "satellite navigation with drift, outages and multipath", make_module_config<GnssConfig>},
     make_gnss_sensor},
    {{"altimeter", "laser rangefinder that looks down", make_module_config<AltimeterConfig>}, make_altimeter_sensor},
    {{"compass", "heading from a magnetometer", make_module_config<CompassConfig>}, make_compass_sensor},
    {{"odometry", "visual-inertial odometry in a local frame that drifts", make_module_config<OdometryConfig>},
     make_odometry_sensor},
    {{"neighbors", "other vehicles by mutual localization (UVDAR)", make_module_config<NeighborsConfig>},
     make_neighbors_sensor},
    {{"lidar", "LiDAR: Ouster, Livox Mid-360, Velodyne Puck, or any pattern", make_module_config<LidarConfig>},
     make_lidar},
};

}  // namespace

std::span<const SensorType> sensor_types() { return kSensorTypes; }

std::span<const ModuleType> sensor_module_types() {
  static const std::vector<ModuleType> types = [] {
    std::vector<ModuleType> modules;
    for (const SensorType& type : kSensorTypes) modules.push_back(type.module);
    return modules;
  }();
  return types;
}

std::vector<std::string> sensor_names(std::span<const Module> sensors) {
  std::vector<std::string> names(sensors.size());
  const auto taken = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  // What the user named comes first, so that no generated name takes one of these.
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const auto* config = dynamic_cast<const SensorConfig*>(sensors[i].config.get());
    if (config == nullptr || config->name.empty()) continue;
    if (taken(config->name)) throw std::invalid_argument("two sensors are named '" + config->name + "'");
    names[i] = config->name;
  }
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (!names[i].empty()) continue;
    std::string name = sensors[i].type;
    for (int number = 2; taken(name); ++number) name = sensors[i].type + std::to_string(number);
    names[i] = name;
  }
  return names;
}

std::unique_ptr<Sensor> make_sensor(const Module& config, SensorSetup setup) {
  for (const SensorType& type : kSensorTypes) {
    if (config.type == type.module.name) return type.make(*config.config, std::move(setup));
  }
  throw std::invalid_argument("no sensor type is named '" + config.type + "'");
}

}  // namespace swiftlet::sim
