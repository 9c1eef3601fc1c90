// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/slam/graph/branch_and_bound.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/slam/closure_config.hpp"

namespace swiftlet {

/// Result of the attempt to join two submaps; in the order of the checks.
enum class ClosureVerdict {
  kTooFlat,      ///< too few upright structures for a unique pose
  kNoMatch,      ///< no pose in the window reaches the minimum score
  kNotSearched,  ///< the budget ended the search
  kRival,        ///< another pose scores about as well, as in parallel aisles
  kOpen,         ///< a direction is not constrained by the surfaces
  kMoved,        ///< the refinement left the pose found by the search
  kNoOverlap,    ///< too small a share of one submap overlaps the other
  kDoesNotFit,   ///< too large a share of the overlap is off the surfaces
  kClosed,
};

struct ClosureResult {
  ClosureVerdict verdict = ClosureVerdict::kNoMatch;
  Pose T_older_newer = Pose::Identity();  ///< valid for kClosed
  /// Projector onto the constrained directions of that pose, for kClosed: the identity, or without the one
  /// unconstrained direction. Displacements are in axes of the older submap, rotations in those of the newer.
  Matrix6 constrained = Matrix6::Identity();
  double score = 0.0, overlap = 0.0, near_share = 0.0;
  std::int64_t num_expanded = 0;
};

/// Finds the pose of one submap in another around a guess: branch and bound over headings and displacements, then
/// refinement from points to surfaces. A false closure is worse than none, so ambiguous results are rejected.
///
/// If the guess is already accurate, the points fit the surfaces without a search. The surfaces may then leave one
/// direction unconstrained, as a wall and the floor do; the closure does not constrain it.
///
/// Frames of submaps have z up.
/// @param guess_off_m  maximum error of the guess: poses farther away are rejected
ClosureResult find_closure(std::span<const Eigen::Vector3f> points_older_m,
                           std::span<const Eigen::Vector3f> points_newer_m, const Pose& T_older_newer_guess,
                           const ClosureConfig& config, double guess_off_m = std::numeric_limits<double>::infinity());

/// A submap of a map; poses are in the frame of the map.
struct MapPart {
  Pose T_map_part = Pose::Identity();
  std::span<const Eigen::Vector3f> points_part_m;
  const RotationalHistogram* directions = nullptr;  ///< null: computed from the points
};

struct MapMatch {
  ClosureResult result;  ///< pose in the part
  std::size_t part = 0;  ///< index of the part that contains the cloud, when closed
};

/// Finds the part of a map that contains a cloud, and its pose. Each part is searched around its center within the
/// window. The result is rejected when another position in the map, or another heading, scores about as well.
///
/// @param directions  histogram of the cloud; null: computed from its points
MapMatch find_in_map(std::span<const MapPart> parts, std::span<const Eigen::Vector3f> points_newer_m,
                     const ClosureConfig& config, const RotationalHistogram* directions = nullptr);
/// One point in each occupied cell of columns with structure at least a meter high. Floors, which match anywhere, are
/// removed. The cloud's frame has z up. Any frame, the same for all arguments.
std::vector<Eigen::Vector3f> upright_points_m(std::span<const Eigen::Vector3f> points_cloud_m, double cell_m,
                                              double range_max_m);

}  // namespace swiftlet
