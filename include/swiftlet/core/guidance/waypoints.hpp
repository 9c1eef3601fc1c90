// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/guidance/separation_config.hpp"

namespace swiftlet {

/// Flight along waypoints. A waypoint is reached within the arrival radius; the vehicle then stays for the dwell time
/// and continues. Done when the last dwell time has elapsed (or when landed).
struct WaypointsConfig : ModuleConfigOf<WaypointsConfig> {
  std::vector<Eigen::Vector3d> waypoints_m;
  enum class Frame { kWorld, kStart };
  Frame frame = Frame::kWorld;
  double speed_mps = 2.0;
  double arrival_radius_m = 0.5;
  double dwell_s = 0.0;
  bool loop = false;
  bool land_at_end = false;
  enum class Yaw { kAlongPath, kAtNext, kFixed };
  Yaw yaw = Yaw::kAlongPath;
  double yaw_deg = 0.0;
  KeepApartConfig separation;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_waypoints(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
