// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/slam/inertial_filter.hpp"
#include "swiftlet/core/slam/surface_map.hpp"

namespace swiftlet {

struct ScanToMapConfig {
  double kernel_sigma = 3.0;
  double reach_m = 0.5;
  double surface_sigma_m = 0.01;
  double point_weight = 0.02;
  double degenerate_share = 0.003;
  int standing_points = 10;
  double floor_position_m = 0.003;
  double floor_attitude_deg = 0.02;

  void visit(ConfigVisitor& v);
};

/// How well a scan fits the map, beside the evidence itself.
struct ScanFit {
  PoseEvidence evidence;
  int num_points = 0;      ///< of the scan
  int num_known = 0;       ///< that lie where the map has a surface
  int num_planar = 0;      ///< of these, with a plane
  int num_near = 0;        ///< of the known ones, within three standard deviations
  int num_fresh = 0;       ///< of the known ones, in cells that still take points
  int num_degenerate = 0;  ///< directions of the pose (of six) of which the scan tells nothing
  int num_held = 0;        ///< of which only what stands free tells something
};

/// The cost of a pose: distances of points from the planes of the map, or from the means of cells that have none
/// [GenZ-ICP 2025]. The scatter of its cell and a robust kernel (Geman and McClure) weight each.
///
/// Directions of which the planes tell little are taken out of the evidence (Zhang, Kaess and Singh, ICRA 2016). So
/// noise of the normals cannot hold the vehicle in an aisle. Such a direction comes back with the evidence of the
/// points that stand free along it, when there are enough. A point stands free when it lies on a plane across the
/// direction or on a pole, but on nothing 0.7 m ahead and behind. Beside some of them a beam has to go by,
/// where a wall would have gone on. Stems stand free, floors and walls do not.
///
/// The local frame's z axis is up: poles are upright.
/// @param smear_m  how far the points may be off because the motion during the sweep was not known
ScanFit fit_scan(const SurfaceMap& map, std::span<const Eigen::Vector3f> points_body_m, const Pose& T_local_body,
                 const ScanToMapConfig& config, double smear_m = 0.0);

}  // namespace swiftlet
