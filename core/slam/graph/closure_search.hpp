// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/slam/graph/branch_and_bound.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/slam/closure_config.hpp"

namespace swiftlet {

/// [m] Value of ClosureCandidate::guess_error_m of a candidate without a guess.
inline constexpr double kNoGuess = std::numeric_limits<double>::infinity();
/// [-] Largest error of a guess, in its standard deviations. Larger values search farther, and find more false poses.
inline constexpr double kErrorSigmas = 3.0;

/// An older submap in which a newer one is searched. Frames of submaps have z up.
struct ClosureCandidate {
  Pose T_map_older = Pose::Identity();  ///< in the common frame of all candidates
  std::span<const Eigen::Vector3f> points_older_m;
  const RotationalHistogram* directions = nullptr;  ///< histogram of these points; null: computed from them
  Pose T_older_newer_guess = Pose::Identity();
  /// Largest error of the guess [m]. kNoGuess: every heading is searched, within search_radius_m of the older submap's
  /// center.
  double guess_error_m = kNoGuess;
};

/// One point in each occupied cell of columns with structure at least a meter high. Floors, which match anywhere, are
/// removed. The cloud's frame has z up. Any frame, the same for all arguments.
std::vector<Eigen::Vector3f> upright_points_m(std::span<const Eigen::Vector3f> points_cloud_m, double cell_m,
                                              double range_max_m);

/// Keeps at most `most` points, evenly spread over the list. Any frame, the same for all arguments.
void keep_at_most(std::size_t most, std::vector<Eigen::Vector3f>& points_m);

/// Pose of the newer submap in one of the candidates.
struct CandidatePose {
  std::size_t candidate = 0;
  Pose T_older_newer = Pose::Identity();
  double score = 0.0;  ///< share of the points in occupied cells
};

/// Branch and bound over displacements and headings of the newer submap's upright structure, in all candidates.
class ClosureSearch {
 public:
  /// @param upright_older_m  upright_points_m() of each candidate
  /// @param directions_newer  histogram of points_newer_m; null: computed from them
  ClosureSearch(std::span<const ClosureCandidate> candidates,
                std::span<const std::vector<Eigen::Vector3f>> upright_older_m,
                std::span<const Eigen::Vector3f> points_newer_m, std::span<const Eigen::Vector3f> upright_newer_m,
                const RotationalHistogram* directions_newer, const ClosureConfig& config);

  /// Best pose of all candidates with at least this score, if any. When the budget has ended the search, complete() is
  /// false and the best pose may be missed.
  std::optional<CandidatePose> best_pose(double score_min);
  /// Best other pose in one candidate: at another place, or with another heading.
  std::optional<CandidatePose> best_rival(const CandidatePose& best, std::size_t candidate, double score_min);

  bool complete() const { return complete_; }
  std::int64_t num_expanded() const { return num_expanded_; }

 private:
  std::optional<CandidatePose> search(std::size_t candidate, double score_min, const Excluded* excluded);

  const ClosureConfig& config_;
  std::span<const ClosureCandidate> candidates_;
  std::span<const std::vector<Eigen::Vector3f>> upright_older_m_;
  std::vector<Eigen::Vector3f> searched_m_;  // points of the newer submap
  std::vector<SearchWindow> windows_;
  std::vector<std::vector<std::uint8_t>> likely_headings_;  // a flag for each heading of the window
  std::optional<OccupancyPyramid> pyramid_;                 // grid of candidate pyramid_of_, searched last
  std::size_t pyramid_of_ = 0;
  std::int64_t num_expanded_ = 0;
  bool complete_ = true;
};

/// [-] Fewest points of upright structure that determine a pose. Smaller values find more poses in the open, also false
/// ones.
inline constexpr std::size_t kMinUpright = 40;

}  // namespace swiftlet
