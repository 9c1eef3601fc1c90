// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/render/render_config.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {

void CameraConfig::visit(ConfigVisitor& v) {
  v.field("name", name, "name of the camera, part of the names of the pictures");
  v.choice("type", type, kTypes, "kind of picture: a view of the world, metric depth, or measurements of a LiDAR");
  v.field("vehicle", vehicle,
          "follow, top, onboard, depth, lidar_*: name of the vehicle; empty: the first (follow, top: all)");
  v.field("sensor", sensor, "lidar_*: name of the vehicle's LiDAR; empty: the first");
  v.field("position_m", position_m,
          "[m] fixed: world; follow: offset from the vehicles along the world's axes; onboard, depth: body frame; both "
          "zero: "
          "chosen by the type");
  v.field("target_m", target_m,
          "[m] point in the middle of the view. fixed: world; onboard, depth: body frame; top: center, when span_m is "
          "given");
  v.field("fov_deg", fov_deg, "[deg] vertical field of view", Range::between(5.0, 150.0));
  v.field("span_m", span_m, "[m] top: height of the area shown; 0: all vehicles with their trails",
          Range::non_negative());
  v.field("width_px", width_px, "[px] width of the picture", Range::between(64, 8192));
  v.field("height_px", height_px, "[px] height of the picture", Range::between(64, 8192));
  v.choice("style", style, {"screen", "paper"},
           "medium; paper: white, without captions, as PNG and as SVG with editable text");
  v.field("width_mm", width_mm, "[mm] paper: width as printed; 0: width_px at dpi", Range::non_negative());
  v.field("height_mm", height_mm, "[mm] paper: height as printed; 0: in proportion to the width",
          Range::non_negative());
  v.field("dpi", dpi, "paper: pixels per 25.4 mm", Range::between(30.0, 2400.0));
  v.field("text_pt", text_pt, "[pt] paper: printed font size", Range::between(3.0, 40.0));
  v.field("max_range_m", max_range_m, "[m] depth, lidar_range: end of the color scale; 0: fitted to the picture",
          Range::non_negative());
  v.field("times_s", times_s, "[s] times of pictures", Range::non_negative());
  v.field("every_s", every_s, "[s] period of further pictures; 0: none", Range::non_negative());
  v.choice("cloud", cloud, {"none", "height", "label", "intensity", "vehicle"},
           "quantity that colors the latest scans, drawn in the world; none: no scans");
  v.field("point_px", point_px, "[px] diameter of the points of clouds; 0: decreases with distance",
          Range::between(0.0, 64.0));
  v.field("trails", trails, "whether the flown path of each vehicle is drawn; never by an onboard camera");
  v.field("names", names, "whether vehicles are labeled with their names");
  v.field("overlays", overlays, "overlays of the agents to draw, by name, of one vehicle as \"uav1/NAME\"; \"*\": all");
  v.field("axes", axes, "follow, fixed, top: whether a corner shows the axes of the world");
  v.field("vehicle_scale", vehicle_scale, "factor on the drawn size of vehicles", Range{0.0, 1000.0, true, false});
  v.field("vehicle_min_px", vehicle_min_px,
          "[px] size on the picture below which a vehicle gets a ring of this diameter in its color; 0: no rings",
          Range::non_negative());
  v.field("cut_above", cut_above, "whether everything above cut_height_m is hidden, for views under crowns and roofs");
  v.field("cut_height_m", cut_height_m, "[m] height of the cut, world frame");
  v.check(!times_s.empty() || every_s > 0.0, "times_s", "times of pictures, here or by every_s");
  v.check(on_paper() || width_mm <= 0.0, "width_mm", "style paper: a screen has no millimeters");
  v.check(on_paper() || height_mm <= 0.0, "height_mm", "style paper: a screen has no millimeters");
  const Eigen::Vector2i size = size_px();
  v.check((width_mm <= 0.0 && height_mm <= 0.0) || (size.minCoeff() >= 64 && size.maxCoeff() <= 8192),
          width_mm > 0.0 ? "width_mm" : "height_mm", "a picture of 64 to 8192 px a side at the dpi given");
  v.check(!name.empty() && name.find('/') == std::string::npos && name != "." && name != "..", "name",
          "a name that can be part of a file's name");
}

Eigen::Vector2i CameraConfig::size_px() const {
  if (!on_paper() || (width_mm <= 0.0 && height_mm <= 0.0)) return {width_px, height_px};
  const double ratio = static_cast<double>(height_px) / std::max(1, width_px);
  const double wide_mm = width_mm > 0.0 ? width_mm : height_mm / ratio;
  const double high_mm = height_mm > 0.0 ? height_mm : wide_mm * ratio;
  const auto pixels = [&](double mm) { return static_cast<int>(std::lround(std::min(mm / 25.4 * dpi, 1e6))); };
  return {pixels(wide_mm), pixels(high_mm)};
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

void require_pictures(const std::string& place, const std::string& otherwise) {
  if (!picture_library().empty()) return;
  throw InputError(place +
                   "expected a program that draws pictures, found one built without; install libegl-dev and "
                   "libgl1-mesa-dri, or libosmesa6-dev, and build Swiftlet again with -DSWIFTLET_PICTURES=AUTO" +
                   otherwise);
}

}  // namespace swiftlet::sim
