// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/slam/matching/inertial_filter.hpp"
#include "core/slam/matching/scan_to_map.hpp"
#include "core/slam/matching/surface_map.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {

/// Surfaces of the older submap and points of the newer one.
struct SubmapPair {
  SubmapPair(std::span<const Eigen::Vector3f> points_older_m, std::span<const Eigen::Vector3f> points_newer_m,
             std::span<const Eigen::Vector3f> upright_newer_m);

  SurfaceMap surfaces;
  std::span<const Eigen::Vector3f> newer_m, upright_newer_m;
  std::vector<Eigen::Vector3f> fitted_newer_m;  ///< subset of newer_m for the alignment
};

/// Prior knowledge of a pose, as information [1/m^2, 1/rad^2].
struct PosePrior {
  Pose T_older_newer = Pose::Identity();
  Matrix6 information = Matrix6::Zero();
};

PosePrior prior_of(const Pose& T_older_newer_guess, double largest_error_m);

/// First standard deviation of the surfaces in an alignment, that is its reach: 0.3 m or 0.03 m.
enum class Reach { kWide = 0, kClose = 2 };

/// Alignment of the newer submap to the surfaces of the older one by Gauss-Newton, coarse to fine.
/// @param prior  keeps the pose in directions that the surfaces leave unobserved; none: no direction may be
/// @param T_older_newer  start pose; receives the result
/// @return number of unobserved directions
int align(const SubmapPair& pair, const std::optional<PosePrior>& prior, Reach reach, Pose& T_older_newer);

/// Moves the pose to the height at which most points lie on surfaces, floors included: walls hardly constrain it.
void align_height(const SubmapPair& pair, double cell_m, Pose& T_older_newer);

/// Fit of a cloud to the surfaces with the finest deviation.
/// @param allows_unobserved  takes directions with little information as unobserved, which the prior has to keep
ScanFit fit_finely(const SubmapPair& pair, std::span<const Eigen::Vector3f> points_newer_m, const Pose& T_older_newer,
                   bool allows_unobserved);

/// Projector onto the directions of a pose that the evidence observes.
Matrix6 observed_directions(const PoseEvidence& evidence, int num_unobserved);

/// Poses of the newer submap, shifted along the direction that the surfaces observe least.
struct ShiftedPoses {
  PoseEvidence evidence;  // at the unshifted pose
  Vector6 step;           // direction of the shifts
  std::vector<Pose> T_older_newer;
  std::vector<double> offset_m;
  std::vector<int> num_near;  // number of points on surfaces

  /// Index of the shift with the most points on surfaces.
  std::size_t best() const;
  /// True if the submap fits about as well after a shift: the apparent constraint along that direction then comes from
  /// errors of normals, or from ledges that meet other ledges.
  bool fits_elsewhere() const;
  /// Distance of another pose from the line of the shifted poses. A pure rotation has no line: there it is the distance
  /// from the unshifted pose.
  double distance_from_line_m(const Pose& T_older_newer) const;
};

/// @param reach_m  largest shift to either side; poses are sampled from the unshifted one outward
ShiftedPoses sample_shifts(const SubmapPair& pair, const Pose& T_older_newer, double reach_m);

}  // namespace swiftlet
