// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet::sim {

/// A capture: the interceptor's net met another vehicle.
struct CaptureRecord {
  static constexpr const char* kName = "captures";
  TimeNs t = 0;
  VehicleId target = kNoVehicle;
  int number = 0;       ///< running number of the interceptor's captures, from 1
  double miss_m = 0.0;  ///< distance from the center of the net to the meeting point
  double relative_speed_mps = 0.0;
  Vector3 p_world_m = Vector3::Zero();  ///< position of the target

  static void visit(auto& c, auto& v) {
    v.time("t_s", c.t, "[s] time of the capture");
    v.vehicle("target", c.target, "[-] captured vehicle");
    v.field("number", c.number, "[-] running number of the interceptor's captures, from 1");
    v.field("miss_m", c.miss_m, "[m] distance from the center of the net to the meeting point");
    v.field("relative_speed_mps", c.relative_speed_mps, "[m/s] relative speed of target and net");
    v.field("position_*_m", c.p_world_m, "[m] true position of the target in the world");
  }
};

}  // namespace swiftlet::sim
