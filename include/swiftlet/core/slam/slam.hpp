// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/config.hpp"
#include "swiftlet/core/localization/estimator.hpp"
#include "swiftlet/core/slam/global_slam.hpp"
#include "swiftlet/core/slam/grid_matcher.hpp"
#include "swiftlet/core/slam/local_slam.hpp"

namespace swiftlet {

/// Where am I, by nothing but LiDAR and IMU. The compass gives the heading at the start to a vehicle that was not told
/// it, and the first GNSS fix after that its place [Orsulic 2021, sec. III-C]. With `global` it closes loops and takes
/// GNSS fixes in; a new correction is shown little by little.
struct SlamConfig : ModuleConfigOf<SlamConfig> {
  /// What scans are matched to: planes, or the document's grids of probability.
  enum class Matching { kSurfaces, kGrid };

  std::vector<std::string> lidars;
  double latency_s = 0.03;
  Matching matching = Matching::kSurfaces;
  LocalSlamConfig local;
  GridMatchingConfig grid;
  GlobalSlamConfig global;
  double warn_after_s = 0.35;
  double lidar_timeout_s = 3.0;
  double imu_timeout_s = 0.1;
  double position_sigma_max_m = 2.0;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<StateEstimator> make_slam_estimator(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
