// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/sim/sensors/lidar_faults_config.hpp"
#include "swiftlet/sim/sensors/lidar_measurement.hpp"
#include "swiftlet/sim/sensors/lidar_mount.hpp"
#include "swiftlet/sim/sensors/lidar_pattern.hpp"
#include "swiftlet/sim/sensors/mount_error_config.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {

/// The pose measurement that the agent receives with each scan, with the noise of Sigma_w [Vrba 2025, sec. IV-A and eq.
/// 66]. The noise transforms the measurement into the truth (eqs. 40, 41):
///   t_m = t_gt - t_n,  R_m = R_gt R_n^T  with  R_n = Rz Ry Rx.
/// White: one draw for each sweep. Correlated: a stationary Gauss-Markov process.
struct ExternalPoseConfig {
  bool enabled = false;
  double sigma_position_m = 0.05;
  double sigma_rotation_rad = 0.005;
  double correlation_time_s = 0.0;
  double spacing_s = 0.01;

  void visit(ConfigVisitor& v);
};

/// A LiDAR: mounting, scan pattern and measurement model. The defaults are an Ouster OS1-128.
struct LidarConfig : SensorConfigOf<LidarConfig> {
  std::string model;
  double rate_hz = 10.0;
  bool rolling = true;     ///< false: all beams fire at the scan's stamp
  bool ideal = false;      ///< no noise, no lost returns, no faults, infinitely thin beams, true poses
  bool self_mask = false;  ///< removes the returns of beams that can intersect the own vehicle
  double range_min_m = 0.8;
  double range_max_m = 120.0;
  MountConfig mount;
  MountErrorConfig mount_error;
  Module pattern{lidar_pattern_types(), "ouster"};
  RangeNoiseConfig noise;
  DetectionConfig detection;
  BeamWidthConfig beam;
  LidarFaultsConfig faults;
  ExternalPoseConfig external_pose;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Sensor> make_lidar(const ModuleConfig& config, SensorSetup setup);

}  // namespace swiftlet::sim
