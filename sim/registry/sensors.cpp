// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/registry/sensors.hpp"

#include "swiftlet/sim/sensors/altimeter.hpp"
#include "swiftlet/sim/sensors/clocked_sensor.hpp"
#include "swiftlet/sim/sensors/compass.hpp"
#include "swiftlet/sim/sensors/gnss.hpp"
#include "swiftlet/sim/sensors/imu.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"
#include "swiftlet/sim/sensors/odometry.hpp"
#include "swiftlet/sim/sensors/pose.hpp"

namespace swiftlet::sim {
namespace {

// All sensors: a new sensor needs one line here.
constexpr SensorType kSensorTypes[] = {
    {{"pose", "external pose: motion capture, RTK, or the truth itself", make_module_config<PoseConfig>},
     make_pose_sensor},
    {{"imu", "rates and specific force, with bias and noise", make_module_config<ImuConfig>}, make_imu_sensor},
    {{"gnss", "satellite navigation with drift, outages and multipath", make_module_config<GnssConfig>},
     make_gnss_sensor},
    {{"altimeter", "laser rangefinder that points down", make_module_config<AltimeterConfig>}, make_altimeter_sensor},
    {{"compass", "heading from a magnetometer", make_module_config<CompassConfig>}, make_compass_sensor},
    {{"odometry", "visual-inertial odometry in a local frame that drifts", make_module_config<OdometryConfig>},
     make_odometry_sensor},
    {{"neighbors", "other vehicles by mutual localization (UVDAR)", make_module_config<NeighborsConfig>},
     make_neighbors_sensor},
    {{"lidar", "LiDAR: Ouster, Livox Mid-360, Velodyne Puck, or any pattern", make_module_config<LidarConfig>},
     make_lidar},
};

void note_samples(const SensorType& row) {
  if (row.samples != nullptr) sample_tables().push_back(row.samples());
}

}  // namespace

Registry<SensorType>& sensor_registry() {
  static Registry<SensorType> table("sensor", kSensorTypes, note_samples);
  return table;
}

std::unique_ptr<Sensor> make_sensor(const Module& config, SensorSetup setup) {
  const auto& common = dynamic_cast<const SensorConfig&>(*config.config);
  return with_clock(sensor_registry().make(config, setup), common, setup);
}

}  // namespace swiftlet::sim
