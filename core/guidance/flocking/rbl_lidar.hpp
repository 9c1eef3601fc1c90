// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/guidance/flocking/rbl_cell.hpp"
#include "core/guidance/flocking/rbl_obstacles.hpp"
#include "core/guidance/flocking/rbl_planner.hpp"
#include "core/guidance/flocking/rbl_viewed.hpp"
#include "core/guidance/half_space.hpp"
#include "swiftlet/core/guidance/rbl_config.hpp"

namespace swiftlet {

/// LiDAR mode of the rule-based Lloyd algorithm [Kamler 2025, chapter 3]: the cell keeps clear of the voxels of the
/// vehicle's own map, and the vehicle flies only to positions in its field of view.
class RblLidar {
 public:
  RblLidar(const RblConfig& config, bool planar);

  /// The vehicle in its map at an update, in the local frame.
  struct Situation {
    const Pose& T_local_body;
    const OccupancyView& map;
    Vector3 goal_local_m = Vector3::Zero();
    double z_min_m = 0.0, z_max_m = 0.0;  ///< allowed flight heights
    TimeNs now = 0;
  };

  /// Cuts the cell by occupied voxels. If no room is left, obstacles take precedence over neighbors, which may yield.
  void cut(const Situation& situation, RblPlanner& planner);
  /// Planes of the obstacles at the last cut, relative to the vehicle.
  std::span<const HalfSpace> cuts() const { return cuts_; }

  /// Next goal toward the centroid of the cell, or straight along a detour.
  /// @param straight_local_m  point of the detour, if the cell holds the vehicle
  /// @param yaw_rad           commanded heading; turned towards the flight direction
  Vector3 next_local_m(const Situation& situation, const RblCell& cell, const Vector3& centroid_local_m,
                       const std::optional<Vector3>& straight_local_m, double& yaw_rad);
  /// Heading [rad] toward a position, for a vehicle that does not wait until the position is in view.
  static double heading_to(const Situation& situation, const Vector3& q_local_m, double yaw_rad);

  /// Height [m] nearest to the wanted one that the vehicle can reach vertically through viewed space free in the map.
  double clear_height_local_m(const Situation& situation, double wanted_m) const;
  /// Horizontal distance from the goal at which the goal lies within the vertical field of view, at the vehicle's
  /// height.
  double sees_goal_from_m(double up_m) const;
  /// @param p_lidar_body_m  mounting position of the sensor
  void mount(const Vector3& p_lidar_body_m) { p_lidar_body_m_ = p_lidar_body_m; }

 private:
  void cut_by(RblCell& cell, std::vector<HalfSpace>& cuts, const Situation& situation, TimeNs since);
  Vector3 within_sight(const Situation& situation, const RblCell& cell, const Vector3& centroid_local_m,
                       double& yaw_rad);
  Vector3 straight_on(const Situation& situation, const RblCell& cell, const Vector3& centroid_local_m,
                      const Vector3& next_local_m, double& yaw_rad);
  std::optional<Vector3> slowly_local_m(const Situation& situation, const Vector3& displacement_local_m) const;
  bool faces(const Pose& T_local_body, double yaw_rad) const;
  std::array<HalfSpace, 2> view(const Matrix3& R_local_body) const;
  std::array<HalfSpace, 2> level_view(const Matrix3& R_local_body) const;

  RblCellConfig cells_;
  RblLidarConfig config_;
  bool separated_;  // neighbors yield to obstacles, and places viewed before may be approached out of view
  RblCell sensed_;  // A'
  Vector3 p_lidar_body_m_ = Vector3::Zero();
  std::vector<HalfSpace> cuts_, sensed_cuts_;
  std::vector<Vector3> voxels_local_m_;
  ObstacleCutter cutter_;
  RblViewed viewed_;
};

}  // namespace swiftlet
