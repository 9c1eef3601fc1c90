// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// A beam of a scan: from the sensor to the hit, or to the end of the observed free space.
struct MapRay {
  Eigen::Vector3f origin_world_m = Eigen::Vector3f::Zero();
  Eigen::Vector3f end_world_m = Eigen::Vector3f::Zero();
  bool hit = true;

  static void visit(auto& r, auto& v) {
    v.field("origin_*_m", r.origin_world_m, "[m] position of the sensor, world frame");
    v.field("end_*_m", r.end_world_m, "[m] end of the beam, world frame");
    v.field("hit", r.hit, "[-] false: free up to the end");
  }
};

/// Beams of a scan for the map of another vehicle. A scan of 30 000 beams takes 800 kB, which exceeds most links.
struct MapRays {
  static constexpr const char* kTopic = "map_rays";
  static constexpr int kVersion = 1;
  static constexpr const char* kDoc = "beams of a scan, for the map of the receiver";

  TimeNs t = 0;
  std::vector<MapRay> rays;

  static void visit(auto& m, auto& v) {
    v.time("t_s", m.t, "[s] end of the sweep");
    v.list("num_rays", m.rays, "[-] beams: origin and end [m] in the sender's world frame, and hit");
  }
};

}  // namespace swiftlet
