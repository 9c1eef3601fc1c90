// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/time.hpp"

namespace swiftlet::sim {

/// What the points of a scan that is drawn are colored by.
enum class CloudColors { kNone, kHeight, kLabel, kIntensity, kVehicle };

/// What a picture is made for. On paper it is white, has no captions, and comes as PNG and as SVG.
enum class PictureMedium { kScreen, kPaper };

/// One named camera and when it takes pictures.
struct CameraConfig {
  std::string name = "top";
  enum class Type { kTop, kFollow, kFixed, kOnboard, kDepth, kLidarRange, kLidarIntensity };
  static constexpr const char* kTypes[] = {"top",   "follow",      "fixed",          "onboard",
                                           "depth", "lidar_range", "lidar_intensity"};
  Type type = Type::kTop;
  std::string vehicle;  ///< follow, onboard, depth, lidar_*: whose; empty: the first (follow: all of them)
  std::string sensor;   ///< lidar_*: which LiDAR of the vehicle; empty: the first
  /// Where it is and what it looks at. Both zero: chosen by the type.
  /// - fixed: world;
  /// - follow: position is the offset from the vehicle(s) along the axes of the world, whatever the heading. Its length
  ///   is the least distance; zero: by the size of the vehicles. Where the world blocks the sight, the camera goes
  ///   round;
  /// - onboard, depth: body frame;
  /// - top: target is the center, when span_m is given.
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero();
  double fov_deg = 60.0;     ///< vertical
  double span_m = 0.0;       ///< top: height of the area shown; 0: vehicles and trails
  bool perspective = false;  ///< top: seen from high above instead of a parallel projection
  int width_px = 1280;
  int height_px = 720;
  PictureMedium style = PictureMedium::kScreen;
  double width_mm = 0.0;        ///< paper: its width as printed; 0: width_px at `dpi`
  double height_mm = 0.0;       ///< paper: its height as printed; 0: as width_px and height_px stand to each other
  double dpi = 300.0;           ///< paper: pixels per 25.4 mm
  double text_pt = 8.0;         ///< paper: size of the letters as printed [pt]
  double max_range_m = 0.0;     ///< depth, lidar_range: end of the color scale; 0: from the picture
  std::vector<double> times_s;  ///< pictures at these times ...
  double every_s = 0.0;         ///< ... and at every multiple of this; 0: none
  CloudColors cloud = CloudColors::kNone;  ///< latest scans drawn in the world
  double point_px = 0.0;                   ///< diameter of the cloud's points; 0: by their distance
  bool trails = true;                      ///< path of each vehicle so far; an onboard camera shows none
  bool names = true;                       ///< of the vehicles, beside them
  std::vector<std::string> overlays;       ///< by name; "*": all
  bool axes = true;                        ///< follow, fixed, top: how the axes of the world lie
  double vehicle_scale = 1.0;              ///< vehicles drawn larger than they are (for wide views)
  double vehicle_min_px = 12.0;            ///< a vehicle that looks smaller gets a ring of this diameter; 0: none
  bool cut_above = false;                  ///< hide what is higher than cut_height_m, to look under crowns and roofs
  double cut_height_m = 3.0;

  void visit(ConfigVisitor& v);
  bool on_paper() const { return style == PictureMedium::kPaper; }
  /// Width and height of the picture [px], from millimeters and dpi where it is made for paper.
  Eigen::Vector2i size_px() const;
  bool looks_through_lidar() const { return type == Type::kLidarRange || type == Type::kLidarIntensity; }
  /// Does this camera take a picture in (previous, now]?
  bool is_due(TimeNs previous, TimeNs now) const;
};

/// Does any camera take a picture in (previous, now]? Pass -1 as `previous` in the first tick, so that t = 0 counts.
bool wants_picture(std::span<const CameraConfig> cameras, TimeNs previous, TimeNs now);

/// Library by which this program draws: "OSMesa" or "EGL"; empty in a program built without pictures.
std::string_view picture_library();
/// Throws InputError in a program built without pictures.
/// @param place      begins the message: "a.yaml:3:1: snapshots: "
/// @param otherwise  ends it with what else the user can do
void require_pictures(const std::string& place, const std::string& otherwise = "");

}  // namespace swiftlet::sim
