// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/render/render_config.hpp"

#include <algorithm>

namespace swiftlet::sim {

void CameraConfig::visit(ConfigVisitor& v) {
  v.field("name", name, "name of the camera, in the names of its pictures");
  v.choice("type", type, kTypes, "what it is: a view of the world, metric depth, or what a LiDAR measures");
  v.field("vehicle", vehicle, "follow, top, onboard, depth, lidar_*: whose; empty: the first (follow, top: all)");
  v.field("sensor", sensor, "lidar_*: which LiDAR of the vehicle; empty: the first");
  v.field("position_m", position_m,
          "[m] fixed: world; follow: offset from the vehicles; onboard, depth: body frame; zero as target_m: by type");
  v.field("target_m", target_m,
          "[m] point looked at. fixed: world; onboard, depth: body frame; top: center, when span_m is given");
  v.field("fov_deg", fov_deg, "[deg] vertical field of view", Range::between(5.0, 150.0));
  v.field("span_m", span_m, "[m] top: height of the area shown; 0: all vehicles with their trails",
          Range::non_negative());
  v.field("perspective", perspective, "top: seen from high above instead of a parallel projection");
  v.field("width_px", width_px, "[px] width of the picture", Range::between(64, 8192));
  v.field("height_px", height_px, "[px] height of the picture", Range::between(64, 8192));
  v.field("max_range_m", max_range_m, "[m] depth, lidar_range: end of the color scale; 0: from the picture",
          Range::non_negative());
  v.field("times_s", times_s, "[s] pictures at these times", Range::non_negative());
  v.field("every_s", every_s, "[s] and at every multiple of this; 0: none", Range::non_negative());
  v.choice("cloud", cloud, {"none", "height", "label", "intensity", "vehicle"},
           "latest scans drawn in the world, and what their colors mean");
  v.field("trails", trails, "draw the path of each vehicle so far");
  v.field("names", names, "write the vehicles' names beside them");
  v.field("overlays", overlays, "overlays of the agents to draw, by name, of one vehicle as \"uav1/NAME\"; \"*\": all");
  v.field("vehicle_scale", vehicle_scale, "vehicles are drawn this many times their size",
          Range{0.0, 1000.0, true, false});
  v.field("cut_above", cut_above, "hide what is higher than cut_height_m, to look under crowns and roofs");
  v.field("cut_height_m", cut_height_m, "[m] height of the cut, world frame");
  v.check(!times_s.empty() || every_s > 0.0, "times_s", "when it takes pictures, here or as every_s");
  v.check(!name.empty() && name.find('/') == std::string::npos && name != "." && name != "..", "name",
          "a name that can be part of a file's name");
}

bool CameraConfig::is_due(TimeNs previous, TimeNs now) const {
  const bool listed = std::any_of(times_s.begin(), times_s.end(), [&](double time_s) {
    const TimeNs t = from_seconds(time_s);
    return previous < t && t <= now;
  });
  if (listed) return true;
  const TimeNs period = from_seconds(every_s);
  if (period <= 0 || now < 0) return false;
  return now / period * period > previous;  // the last multiple up to now
}

bool wants_picture(std::span<const CameraConfig> cameras, TimeNs previous, TimeNs now) {
  return std::any_of(cameras.begin(), cameras.end(),
                     [&](const CameraConfig& camera) { return camera.is_due(previous, now); });
}

}  // namespace swiftlet::sim
