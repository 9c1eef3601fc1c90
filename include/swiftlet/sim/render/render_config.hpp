// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/time.hpp"

namespace swiftlet::sim {

/// Quantity that colors the points of a drawn scan.
enum class CloudColors { kNone, kHeight, kLabel, kIntensity, kVehicle };

/// Medium of a picture. For paper the background is white, without captions, and files are PNG and SVG.
enum class PictureMedium { kScreen, kPaper };

/// One named camera and the times of its pictures.
struct CameraConfig {
  std::string name = "top";
  enum class Type { kTop, kFollow, kFixed, kOnboard, kDepth, kLidarRange, kLidarIntensity };
  static constexpr const char* kTypes[] = {"top",   "follow",      "fixed",          "onboard",
                                           "depth", "lidar_range", "lidar_intensity"};
  Type type = Type::kTop;
  /// Vehicle of follow, onboard, depth and lidar_* cameras; empty: the first (follow: all of them)
  std::string vehicle;
  std::string sensor;  ///< LiDAR of a lidar_* camera; empty: the first of the vehicle
  /// Position and view target. Both zero: chosen by the type.
  /// - fixed: world;
  /// - follow: position is the offset from the vehicle(s) in world axes, independent of heading. Its length is the
  /// least distance; zero: by the size of the vehicles. Where the world blocks the view, the camera moves around it;
  /// - onboard, depth: body frame;
  /// - top: target is the center, when span_m is given.
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero();
  double fov_deg = 60.0;  ///< vertical field of view
  double span_m = 0.0;    ///< top: height of the area shown; 0: fits vehicles and trails
  int width_px = 1280;
  int height_px = 720;
  PictureMedium style = PictureMedium::kScreen;
  double width_mm = 0.0;                   ///< paper: printed width; 0: width_px at `dpi`
  double height_mm = 0.0;                  ///< paper: printed height; 0: by the ratio of height_px to width_px
  double dpi = 300.0;                      ///< paper: pixels per 25.4 mm
  double text_pt = 8.0;                    ///< paper: printed font size [pt]
  double max_range_m = 0.0;                ///< depth, lidar_range: end of the color scale; 0: fitted to the picture
  std::vector<double> times_s;             ///< times of pictures ...
  double every_s = 0.0;                    ///< ... and their period; 0: none
  CloudColors cloud = CloudColors::kNone;  ///< coloring of the latest scans, drawn in the world
  double point_px = 0.0;                   ///< diameter of the cloud's points; 0: decreases with distance
  bool trails = true;                      ///< draw the flown path of each vehicle; not shown by an onboard camera
  bool names = true;                       ///< label each vehicle with its name
  std::vector<std::string> overlays;       ///< names of the overlays to draw; "*": all
  bool axes = true;                        ///< follow, fixed, top: draw the directions of the world axes
  double vehicle_scale = 1.0;              ///< enlargement of drawn vehicles (for wide views)
  /// Vehicles smaller than this on the picture get a ring of this diameter; 0: no rings
  double vehicle_min_px = 12.0;
  bool cut_above = false;  ///< hide everything above cut_height_m, to look under crowns and roofs
  double cut_height_m = 3.0;

  void visit(ConfigVisitor& v);
  bool on_paper() const { return style == PictureMedium::kPaper; }
  /// Width and height of the picture [px]; for paper from millimeters and dpi.
  Eigen::Vector2i size_px() const;
  bool looks_through_lidar() const { return type == Type::kLidarRange || type == Type::kLidarIntensity; }
  /// True if this camera takes a picture in (previous, now].
  bool is_due(TimeNs previous, TimeNs now) const;
};

/// True if any camera takes a picture in (previous, now]. Pass -1 as `previous` in the first tick, so that t = 0
/// counts.
bool wants_picture(std::span<const CameraConfig> cameras, TimeNs previous, TimeNs now);

/// Graphics library of this program: "OSMesa" or "EGL"; empty in a program built without pictures.
std::string_view picture_library();
/// Throws InputError in a program built without pictures.
/// @param place      start of the message: "a.yaml:3:1: snapshots: "
/// @param otherwise  end of the message: alternatives for the user
void require_pictures(const std::string& place, const std::string& otherwise = "");

}  // namespace swiftlet::sim
