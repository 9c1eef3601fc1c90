// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "swiftlet/core/config.hpp"

namespace swiftlet::sim {

/// How the maker's ROS driver lays out its point cloud; kAuto goes by the rows of the scan: 4 Livox, 16 and 32
/// Velodyne, else Ouster. kSmall is no maker's: returns alone, with their place and intensity.
enum class PointsLayout { kAuto, kOuster, kLivox, kVelodyne, kSmall };

/// What the recorders of ROS messages (MCAP, ROS 1 bag) have in common.
struct RosConfig {
  std::vector<std::string> vehicles;
  std::vector<std::string> sensors;
  std::vector<std::string> topics = {"points", "world",    "models", "imu",   "odometry",   "gnss",
                                     "truth",  "estimate", "tf",     "clock", "detections", "tracks"};
  double rate_hz = 100.0;
  int every = 1;
  PointsLayout points_layout = PointsLayout::kAuto;
  double points_step_m = 0.0;
  int world_triangles = 100000;
  Eigen::Vector2d datum_deg = {50.0, 14.0};
  double datum_altitude_m = 0.0;

  void visit_common(ConfigVisitor& v);
};

/// A name as topics and frames have it: letters, digits and underscores; what else it has becomes an underscore.
std::string ros_name(std::string name);

/// What to expect instead of a vehicle's or LiDAR's name; empty: ROS accepts it beside the others.
/// @param taken  the others by their names in ROS; this one joins them
std::string expected_ros_name(const std::string& name, std::map<std::string, std::string>& taken);

}  // namespace swiftlet::sim
