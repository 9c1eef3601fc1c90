// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/slam/graph/closure_search.hpp"
#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/slam/closure_config.hpp"

namespace swiftlet {

/// Result of an attempt to find a submap in others; in the order of the checks.
enum class ClosureVerdict {
  kTooFlat,     ///< too few upright structures for a unique pose
  kNoMatch,     ///< no pose in the window reaches score_min
  kOverBudget,  ///< the budget ended the search
  kAmbiguous,   ///< another pose matches about as well, as in parallel aisles
  kUnobserved,  ///< the surfaces leave a direction unobserved
  kDiverged,    ///< the alignment left the pose of the search, or the error bound of the guess
  kLowOverlap,  ///< the older submap contains less than overlap_min of the newer one
  kPoorFit,     ///< less than near_min of the overlap lies on surfaces
  kClosed,
};

struct ClosureResult {
  ClosureVerdict verdict = ClosureVerdict::kNoMatch;
  std::size_t candidate = 0;              ///< index of the older submap; valid for kClosed
  Pose T_older_newer = Pose::Identity();  ///< valid for kClosed
  /// Projector onto the observed directions of T_older_newer, for kClosed: the identity, or without the one unobserved
  /// direction. Displacements are in axes of the older submap, rotations in those of the newer.
  Matrix6 observed = Matrix6::Identity();
  double score = 0.0;       ///< share of the points in occupied cells; 0: found without a search
  double overlap = 0.0;     ///< share of the newer submap that the older one contains
  double near_share = 0.0;  ///< share of the overlap that lies on surfaces
  std::int64_t num_expanded = 0;

  bool closed() const { return verdict == ClosureVerdict::kClosed; }
};

/// Finds the pose of a submap in older ones, in four steps:
///
/// 1. Candidate: a guess that is nearly right, or the best pose by branch and bound.
/// 2. Alignment of the points to the surfaces of the older submap.
/// 3. Verification of the overlap and of the fit.
/// 4. Rivals: a false closure is worse than none, so ambiguous poses are refused.
///
/// Where a guess is nearly right, the surfaces may leave one direction unobserved, as a wall and the floor do.
/// Frames of submaps have z up.
/// @param directions_newer  histogram of points_newer_m; null: computed from them
ClosureResult find_closure(std::span<const ClosureCandidate> candidates,
                           std::span<const Eigen::Vector3f> points_newer_m, const ClosureConfig& config,
                           const RotationalHistogram* directions_newer = nullptr);

/// Number of attempts by their verdict.
class ClosureCounts {
 public:
  void count(ClosureVerdict verdict) { ++counts_[static_cast<std::size_t>(verdict)]; }
  std::uint64_t operator[](ClosureVerdict verdict) const { return counts_[static_cast<std::size_t>(verdict)]; }
  /// One counter per reason of refusal, with the key of `global.closures` to change.
  /// @param attempts  such as "searches for loop closures"
  void append_counters(const std::string& attempts, std::vector<Counter>& counters) const;

 private:
  std::array<std::uint64_t, static_cast<std::size_t>(ClosureVerdict::kClosed) + 1> counts_{};
};

}  // namespace swiftlet
