// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/core/config.hpp"

namespace swiftlet::sim {

/// One named camera and when it takes pictures.
struct CameraConfig {
  std::string name = "top";
  std::string type = "top";          ///< follow, top, fixed, onboard, depth, lidar_range, lidar_intensity
  std::string vehicle;               ///< follow, onboard, depth, lidar_*: whose; empty: the first (follow: all of them)
  std::string sensor;                ///< lidar_*: which LiDAR of the vehicle; empty: the first
  Eigen::Vector3d position_m = {-10.0, -10.0, 8.0};   ///< fixed: world; follow: offset from the vehicle(s), heading-free; onboard, depth: body frame
  Eigen::Vector3d target_m = {0.0, 0.0, 0.0};         ///< fixed: point looked at, world; onboard, depth: in the body frame
  double fov_deg = 60.0;             ///< vertical
  int width_px = 1280;
  int height_px = 720;
  std::vector<double> times_s;       ///< pictures at these times ...
  double every_s = 0.0;              ///< ... and at every multiple of this; 0: none
  std::string cloud = "none";        ///< latest scans drawn in the world: none, height, label, intensity, vehicle
  bool trails = true;                ///< path of each vehicle so far
  std::vector<std::string> overlays; ///< by name; "*": all
  double vehicle_scale = 1.0;        ///< vehicles drawn larger than they are (for wide views)
  bool cut_above = false;            ///< top: hide what is higher than cut_height_m, to look under crowns and roofs
  double cut_height_m = 3.0;

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
