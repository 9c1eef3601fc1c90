// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "core/slam/matching/inertial_filter.hpp"
#include "core/slam/matching/surface_map.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/slam/local_slam_config.hpp"

namespace swiftlet {

/// Statistics of the fit of a scan to the map, and the evidence.
struct ScanFit {
  PoseEvidence evidence;
  int num_points = 0;      ///< points of the scan
  int num_known = 0;       ///< points where the map has a surface
  int num_near = 0;        ///< known points within the width of the kernel, or in occupied cells
  int num_degenerate = 0;  ///< pose directions (of six) that the scan does not constrain
  int num_held = 0;        ///< directions constrained by free-standing points alone
  /// Share of the map's planes in the variance of the evidence. Common to all scans on these planes, so it does not
  /// average out.
  double map_share = 0.0;
  double renewal = 0.0;  ///< weight of the scan in these planes after an insertion
};

/// Cost of a pose: distances of points to the planes of the map, or to the means of cells without a plane [GenZ-ICP
/// 2025]. Each is weighted by the scatter of its cell and a robust kernel (Geman and McClure).
///
/// Points on one plane share its error, so their joint information is limited to (M^-1 + N^-1)^-1, with the information
/// on offset and slopes of the plane in the map (M) and of that in the scan (N). The scatter of a cell beyond the range
/// noise is structure, such as a ledge, and does not average out over points.
///
/// Directions with little information from the planes are removed from the evidence (Zhang, Kaess and Singh, ICRA
/// 2016), so that noise of the normals does not constrain the vehicle in an aisle. Such a direction is restored by the
/// evidence of points that stand free along it, if there are enough. A point stands free when it lies on a plane across
/// the direction or on a pole, with nothing 0.7 m ahead and behind. Beside some of these points a beam must pass
/// where a wall would have continued. Stems stand free, floors and walls do not.
///
/// The local frame's z axis is up: poles are upright.
/// @param smear_m  possible displacement of the points by unknown motion during the sweep
/// @param range_sigma_m  standard deviation of the ranges
/// @param position_sigma_m  standard deviation of the predicted position, within which free-standing points are
/// recognized
ScanFit fit_scan(const SurfaceMap& map, std::span<const Eigen::Vector3f> points_body_m, const Pose& T_local_body,
                 const ScanToMapConfig& config, double smear_m = 0.0, double range_sigma_m = 0.0,
                 double position_sigma_m = 0.0);

/// fit_scan() with reused memory, for repeated calls.
class ScanFitter {
 public:
  ScanFitter();
  ~ScanFitter();
  ScanFit fit(const SurfaceMap& map, std::span<const Eigen::Vector3f> points_body_m, const Pose& T_local_body,
              const ScanToMapConfig& config, double smear_m = 0.0, double range_sigma_m = 0.0,
              double position_sigma_m = 0.0);

 private:
  class MetPlane;
  class MetPlanes;
  std::unique_ptr<MetPlanes> met_;
};

}  // namespace swiftlet
