// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/slam/inertial_filter.hpp"
#include "swiftlet/core/slam/surface_map.hpp"

namespace swiftlet {

struct ScanToMapConfig {
  double kernel_sigma = 3.0;
  double reach_m = 0.5;
  double surface_sigma_m = 0.005;
  double point_weight = 0.02;
  double degenerate_share = 0.003;
  int standing_points = 10;
  double floor_position_m = 0.0005;
  double floor_attitude_deg = 0.002;

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
  /// The share of the planes of the map in the variance of what the scan tells. All scans that meet them have it in
  /// common. So it does not average out.
  double map_share = 0.0;
  double renewal = 0.0;  ///< the weight that the scan would have in these planes, if it went into the map
};

/// The cost of a pose: distances of points from the planes of the map, or from the means of cells that have none
/// [GenZ-ICP 2025]. The scatter of its cell and a robust kernel (Geman and McClure) weight each.
///
/// The points that meet one plane share its error. So they tell no more than both planes together do, that of the map
/// and the one that the scan has there. That is (M^-1 + N^-1)^-1, with what each knows of offset and slopes. What
/// a cell scatters beyond the noise of ranges is structure, as a ledge is. No number of points averages that out.
///
/// Directions of which the planes tell little are taken out of the evidence (Zhang, Kaess and Singh, ICRA 2016). So
/// noise of the normals cannot hold the vehicle in an aisle. Such a direction comes back with the evidence of the
/// points that stand free along it, when there are enough. A point stands free when it lies on a plane across the
/// direction or on a pole, but on nothing 0.7 m ahead and behind. Beside some of them a beam has to go by,
/// where a wall would have gone on. Stems stand free, floors and walls do not.
///
/// The local frame's z axis is up: poles are upright.
/// @param smear_m  how far the points may be off because the motion during the sweep was not known
/// @param range_sigma_m  noise of the ranges
ScanFit fit_scan(const SurfaceMap& map, std::span<const Eigen::Vector3f> points_body_m, const Pose& T_local_body,
                 const ScanToMapConfig& config, double smear_m = 0.0, double range_sigma_m = 0.0);

/// fit_scan() for who asks again and again: it keeps its memory.
class ScanFitter {
 public:
  ScanFitter();
  ~ScanFitter();
  ScanFit fit(const SurfaceMap& map, std::span<const Eigen::Vector3f> points_body_m, const Pose& T_local_body,
              const ScanToMapConfig& config, double smear_m = 0.0, double range_sigma_m = 0.0);

 private:
  class MetPlane;
  class MetPlanes;
  std::unique_ptr<MetPlanes> met_;
};

}  // namespace swiftlet
