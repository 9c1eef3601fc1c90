// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// Point cloud layout of the manufacturer's ROS driver. kAuto selects it by the rows of the scan: 4 Livox, 16 and 32
/// Velodyne, else Ouster. kSmall is no manufacturer's: returns only, with position and intensity.
enum class PointsLayout { kAuto, kOuster, kLivox, kVelodyne, kSmall };

/// Settings common to the recorders of ROS messages (MCAP, ROS 1 bag).
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

/// A valid name for ROS topics and frames: letters, digits and underscores; any other character becomes an underscore.
std::string ros_name(std::string name);

/// Text after "expected" in the error message for a name of a vehicle or LiDAR that ROS does not accept, or that
/// clashes with one in `taken`; empty: accepted.
/// @param taken  accepted names by their ROS form; `name` is added
std::string expected_ros_name(const std::string& name, std::map<std::string, std::string>& taken);

}  // namespace swiftlet::sim
