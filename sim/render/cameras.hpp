// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <optional>
#include <span>

#include "sim/render/picture_scene.hpp"
#include "swiftlet/sim/render/render_config.hpp"

namespace swiftlet::sim {

/// Pose of a camera and projection of space onto its picture.
/// Camera axes: x right, y up, -z forward. Clip depth runs from 1 (near) to 0 (far), which preserves precision at all
/// distances.
struct View {
  Eigen::Matrix4d T_camera_world = Eigen::Matrix4d::Identity();
  Eigen::Matrix4d clip_camera = Eigen::Matrix4d::Identity();
  Eigen::Vector3d eye_world_m = Eigen::Vector3d::Zero();
  int width_px = 1280;
  int height_px = 720;
  bool orthographic = false;
  double near_m = 0.1;
  double far_m = 1000.0;

  Eigen::Matrix4d clip_world() const { return clip_camera * T_camera_world; }
  /// Pixel (x right, y down, real-valued) of a point and its depth along the optical axis; empty behind the camera.
  std::optional<Eigen::Vector3d> project(const Eigen::Vector3d& p_world_m) const;
  /// Pixels per meter at a depth.
  double pixels_per_m(double depth_m) const;
};

View perspective_view(const Eigen::Vector3d& eye_world_m, const Eigen::Vector3d& target_world_m, double fov_deg,
                      int width_px, int height_px, const Eigen::Vector3d& up_world = Eigen::Vector3d::UnitZ());
/// View straight down, north up; `span_m` is the height of the area shown; includes everything in [bottom, top] in z.
View top_view(const Eigen::Vector2d& center_world_m, double span_m, double bottom_m, double top_m, int width_px,
              int height_px);

/// True if the world blocks the line of sight between two points [m].
using BlocksSight = std::function<bool(const Eigen::Vector3d& a_world_m, const Eigen::Vector3d& b_world_m)>;

/// Frames the pictures of one camera. Follow cameras have inertia: call update() in steps of time, then view(). By
/// default a follow camera stands at its configured offset. Where the world blocks the view, it moves around, higher or
/// nearer, by the least necessary amount, and returns when the view has been free for some seconds.
class CameraController {
 public:
  /// @param vehicle       index of the camera's vehicle; kNoVehicle: all of them
  /// @param radii_m       circumscribed radius of each vehicle as drawn
  /// @param blocks_sight  empty: nothing blocks the view
  CameraController(const CameraConfig& config, VehicleId vehicle, std::vector<float> radii_m,
                   const Eigen::AlignedBox3d& bounds_m, BlocksSight blocks_sight = {});

  /// Size of the following pictures, where it differs from the configured one [px].
  void set_size(int width_px, int height_px);
  void update(TimeNs t, std::span<const VehicleState> states);
  View view(const PictureScene& picture) const;

 private:
  /// Position of a follow camera relative to its target, in world axes.
  struct Stand {
    double azimuth_rad = 0.0;
    double elevation_rad = 0.0;
    double reach = 1.0;  // as a share of the configured distance

    Eigen::Vector3d direction_world() const;
  };

  View follow(const PictureScene& picture) const;
  View top(const PictureScene& picture) const;
  View on_vehicle(const PictureScene& picture) const;
  View fixed() const;
  bool looks_at(std::size_t vehicle) const { return vehicle_ == kNoVehicle || static_cast<int>(vehicle) == vehicle_; }
  Eigen::Vector3d center_of(std::span<const VehicleState> states) const;
  /// Least distance from the target along the direction at which all followed vehicles are in the picture.
  double distance_for_all(const Eigen::Vector3d& target_world_m, const Eigen::Vector3d& direction_world,
                          std::span<const VehicleState> states) const;

  double distance_for(const Eigen::Vector3d& target_world_m, const Stand& stand,
                      std::span<const VehicleState> states) const;
  /// Share of unblocked sight lines to the followed vehicles and their silhouettes.
  double seen_share(const Eigen::Vector3d& target_world_m, const Stand& stand,
                    std::span<const VehicleState> states) const;
  void choose_stand(TimeNs t, const Eigen::Vector3d& target_world_m, std::span<const VehicleState> states);
  Stand freest_stand(const Eigen::Vector3d& target_world_m, std::span<const VehicleState> states) const;

  CameraConfig config_;
  int width_px_ = 0;
  int height_px_ = 0;
  VehicleId vehicle_;
  std::vector<float> radii_m_;
  Eigen::AlignedBox3d bounds_m_;
  BlocksSight blocks_sight_;
  Stand configured_;
  Stand goal_;   // desired
  Stand stand_;  // current, smoothed
  TimeNs tested_at_ = 0;
  std::optional<TimeNs> free_since_;  // since when the view from the configured position is free
  bool started_ = false;
  TimeNs updated_ = 0;
  Eigen::Vector3d target_world_m_ = Eigen::Vector3d::Zero();  // smoothed
  double distance_m_ = 0.0;                                   // smoothed
};

}  // namespace swiftlet::sim
