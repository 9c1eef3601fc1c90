// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/frames.hpp"
#include "swiftlet/core/slam/branch_and_bound.hpp"

namespace swiftlet {

struct ClosureConfig {
  double window_xy_m = 3.0;
  double window_z_m = 1.0;
  double window_yaw_deg = 8.0;
  double cell_m = 0.5;
  int levels = 4;
  int points = 400;
  double range_max_m = 25.0;
  int budget = 200000;
  double histogram_min = 0.6;
  double score_min = 0.5;
  double rival_share = 0.9;
  double rival_distance_m = 1.5;
  double overlap_min = 0.4;
  double near_min = 0.7;

  void visit(ConfigVisitor& v);
};

/// Why two submaps were or were not joined; in the order of the checks.
enum class ClosureVerdict {
  kTooFlat,      ///< too little that stands upright to tell where it is
  kNoMatch,      ///< no pose in the window scores enough
  kNotSearched,  ///< the budget ended the search
  kRival,        ///< another place scores about as well: equal aisles
  kOpen,         ///< the surfaces leave a direction open
  kMoved,        ///< the refinement left the place that was found
  kNoOverlap,    ///< too little of one is known in the other
  kDoesNotFit,   ///< too much of that lies off its surfaces
  kClosed,
};

struct ClosureResult {
  ClosureVerdict verdict = ClosureVerdict::kNoMatch;
  Pose T_older_newer = Pose::Identity();  ///< when closed
  /// When closed, a projector: what the surfaces tell of an error of that pose. It is the identity, or leaves out the
  /// one direction that they leave open. Displacements are in axes of the older submap, turns in those of the newer.
  Matrix6 told = Matrix6::Identity();
  double score = 0.0, overlap = 0.0, near_share = 0.0;
  std::int64_t num_expanded = 0;
};

/// Where one submap lies in another, sought around a guess: branch and bound over headings and displacements, then
/// refinement from points to surfaces. A false closure is worse than none, so it is refused when anything is doubtful.
///
/// A guess that is nearly right needs no search, as its points meet their surfaces at once. These may leave one
/// direction open, as a wall and the floor do. Of that direction the closure then tells nothing.
///
/// Frames of submaps have z up.
/// @param guess_off_m  how far the guess may be off: what is found farther away is refused
ClosureResult find_closure(std::span<const Eigen::Vector3f> points_older_m,
                           std::span<const Eigen::Vector3f> points_newer_m, const Pose& T_older_newer_guess,
                           const ClosureConfig& config, double guess_off_m = std::numeric_limits<double>::infinity());

/// A submap of a map in whose frame all poses are told.
struct MapPart {
  Pose T_map_part = Pose::Identity();
  std::span<const Eigen::Vector3f> points_part_m;
  const RotationalHistogram* directions = nullptr;  ///< null: they are made of the points
};

struct MapMatch {
  ClosureResult result;  ///< its pose is in the part
  std::size_t part = 0;  ///< in which the cloud lies, when closed
};

/// In which part of a map does a cloud lie, and where? Each is searched from its middle on, as far as the windows go.
/// Nothing is taken when another place anywhere in the map scores about as well, or another heading at the same place.
///
/// @param directions  of the cloud; null: they are made of its points
MapMatch find_in_map(std::span<const MapPart> parts, std::span<const Eigen::Vector3f> points_newer_m,
                     const ClosureConfig& config, const RotationalHistogram* directions = nullptr);
/// Defaults for that: any heading, and stricter checks than where an estimate says where to look.
ClosureConfig global_closure_config();
/// The same for a vehicle that looks for itself with few scans: parts of the map may lack some of what it sees.
ClosureConfig locating_config();

/// Of a cloud whose frame has z up: one point in each cell of columns in which something stands at least a meter high.
/// Floors fit anywhere and are left out. Any frame, the same for all arguments.
std::vector<Eigen::Vector3f> upright_points_m(std::span<const Eigen::Vector3f> points_cloud_m, double cell_m,
                                              double range_max_m);

}  // namespace swiftlet
