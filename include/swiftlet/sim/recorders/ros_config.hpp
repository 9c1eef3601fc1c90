// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/core/config.hpp"

namespace swiftlet::sim {

/// How the maker's ROS driver lays out its point cloud; kAuto goes by the rows of the scan: 4 Livox, 16 and 32
/// Velodyne, else Ouster.
enum class PointsLayout { kAuto, kOuster, kLivox, kVelodyne };

/// What the recorders of ROS messages (MCAP, ROS 1 bag) have in common.
struct RosConfig {
  std::vector<std::string> vehicles;
  std::vector<std::string> sensors;
  std::vector<std::string> topics = {"points",   "imu", "odometry", "gnss",       "truth",
                                     "estimate", "tf",  "clock",    "detections", "tracks"};
  double rate_hz = 100.0;
  int every = 1;
  PointsLayout points_layout = PointsLayout::kAuto;
  Eigen::Vector2d datum_deg = {50.0, 14.0};
  double datum_altitude_m = 0.0;

  void visit_common(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
