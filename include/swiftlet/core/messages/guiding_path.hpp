// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// A waypoint of a guided vehicle.
struct GuidingWaypoint {
  Eigen::Vector3f p_body_m = Eigen::Vector3f::Zero();
  float yaw_rad = 0.0F;

  static void visit(auto& w, auto& v) {
    v.field("*_m", w.p_body_m, "[m] position");
    v.field("yaw_rad", w.yaw_rad, "[rad] heading");
  }
};

/// Path for a guided vehicle, relative to the vehicle itself [Pritzl 2024, sec. II-A]. The frame is its level body
/// frame (origin in the body, heading of the body, z up) at the time of one of its odometry reports, or at reception.
/// No other common frame is needed. An empty path means hover.
struct GuidingPath {
  static constexpr const char* kTopic = "guiding_path";
  static constexpr int kVersion = 2;
  static constexpr const char* kDoc = "waypoints for the receiver, in the receiver's level body frame";

  /// kMove: the guide has lost sight of the receiver, which may fly a small pattern to be detected again.
  enum class Command { kGuide, kMove, kDone, kFailed };
  static constexpr std::array<const char*, 4> kCommands = {"guide", "move", "done", "failed"};

  std::uint32_t path = 0;
  Command command = Command::kGuide;
  double radius_m = 0.0;
  bool has_instant = false;
  TimeNs t = 0;
  std::vector<GuidingWaypoint> waypoints;

  static void visit(auto& m, auto& v) {
    v.field("path", m.path, "[-] number of the path; grows with every message");
    v.choice("command", m.command, kCommands,
             "[-] guide: follow the path; move: fly a pattern to be detected; else the mission is over");
    v.field("radius_m", m.radius_m, "[m] radius of the clear space around the receiver, for move");
    v.field("has_instant", m.has_instant, "[-] 1: the body frame is that of an instant, 0: that of reception");
    v.time("t_s", m.t, "[s] time of the body frame, by the receiver's clock");
    v.list("num_waypoints", m.waypoints, "[-] waypoints: position [m] and heading [rad] in that body frame");
  }
};

}  // namespace swiftlet
