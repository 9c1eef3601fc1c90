// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/stage_tables/estimators.hpp"

#include "swiftlet/core/localization/ground_truth.hpp"
#include "swiftlet/core/localization/ins.hpp"
#include "swiftlet/core/localization/odometry.hpp"
#include "swiftlet/core/slam/slam.hpp"

namespace swiftlet {
namespace {

void need_pose(const ModuleConfig&, AgentNeeds& needs) { needs.true_pose = true; }
void need_odometry(const ModuleConfig&, AgentNeeds& needs) {
  needs.sensors.push_back({"odometry", "localization.type: odometry"});
}
void need_imu(const ModuleConfig&, AgentNeeds& needs) { needs.sensors.push_back({"imu", "localization.type: ins"}); }
void need_lidar_and_imu(const ModuleConfig& config, AgentNeeds& needs) {
  const SlamConfig& slam = dynamic_cast<const SlamConfig&>(config);
  needs.sensors.push_back({"lidar", "localization.type: slam"});
  if (slam.imu != SlamConfig::Imu::kNone) needs.sensors.push_back({"imu", "localization.type: slam"});
  for (const std::string& name : slam.lidars) {
    needs.sensors.push_back({"lidar", "localization.lidars", name});
  }
}

constexpr EstimatorType kEstimatorTypes[] = {
    {{"ground_truth", "external pose: the simulator's truth, motion capture, RTK",
      make_module_config<GroundTruthConfig>},
     make_ground_truth_estimator,
     need_pose,
     ""},
    {{"odometry", "visual-inertial odometry in its drifting local frame, and the IMU",
      make_module_config<OdometryEstimatorConfig>},
     make_odometry_estimator,
     need_odometry,
     ""},
    {{"ins", "inertial navigation aided by GNSS, altimeter, compass and odometry", make_module_config<InsConfig>},
     make_ins_estimator,
     need_imu,
     ""},
    {{"slam", "LiDAR and IMU: matches scans to the map built from earlier ones", make_module_config<SlamConfig>},
     make_slam_estimator,
     need_lidar_and_imu,
     "slam.trajectory slam.submaps slam.closures slam.refused slam.joined"},
};

}  // namespace

Registry<EstimatorType>& estimator_registry() {
  static Registry<EstimatorType> table("localization", kEstimatorTypes);
  return table;
}

std::unique_ptr<StateEstimator> make_estimator(const Module& config, const AgentSetup& setup) {
  return estimator_registry().make(config, setup);
}

}  // namespace swiftlet
