// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/localization/estimator.hpp"
#include "swiftlet/core/slam/global_slam_config.hpp"
#include "swiftlet/core/slam/grid_matching_config.hpp"
#include "swiftlet/core/slam/local_slam_config.hpp"

namespace swiftlet {

/// Localization by LiDAR and IMU. An unknown start heading is taken from the compass, and an unknown start position
/// from the first GNSS fix after that [Orsulic 2021, sec. III-C]. With `global` it closes loops and fuses GNSS fixes;
/// new corrections are blended in gradually.
struct SlamConfig : ModuleConfigOf<SlamConfig> {
  /// Map for scan matching: planes, or the document's probability grids.
  enum class Matching { kSurfaces, kGrid };
  /// Prediction between scans: by the IMU, or with constant velocity.
  enum class Imu { kRequired, kNone };

  std::vector<std::string> lidars;
  Imu imu = Imu::kRequired;
  double latency_s = 0.03;
  Matching matching = Matching::kSurfaces;
  LocalSlamConfig local;
  GridMatchingConfig grid;
  GlobalSlamConfig global;
  double warn_after_s = 0.35;
  double lidar_timeout_s = 3.0;
  double imu_timeout_s = 0.1;
  double position_sigma_max_m = 2.0;
  double return_sigma_m = 0.2;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<StateEstimator> make_slam_estimator(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
