// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/closure.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "core/slam/graph/closure_alignment.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// Largest error of a guess whose points still match the right surfaces [m], about one cell. Larger errors are searched.
constexpr double kNearlyRight_m = 0.6;
// [m] Lower bound of the assumed error of a guess: submaps are bent. Smaller values refuse closures of bent submaps.
constexpr double kMinGuessError_m = 0.3;
// Largest correction of a pose of the grid by the alignment. Larger ones lead to another place.
constexpr double kMaxMovedCells = 2.0, kMaxTurned_deg = 4.0;
// [m] Alignments that end farther from each other have found different poses. Larger values overlook rivals.
constexpr double kSamePose_m = 0.1;

struct Refusal {
  const char* reason;   // follows the name of the attempts
  const char* setting;  // key of ClosureConfig to change
};

/// In the order of ClosureVerdict.
constexpr Refusal kRefusals[] = {
    {"with too little upright structure", "range_max_m"},
    {"without a match", "score_min"},
    {"beyond their budget", "budget"},
    {"with an ambiguous pose", "range_max_m"},
    {"with an unobserved direction", "range_max_m"},
    {"whose alignment diverged", "cell_m"},
    {"with too little overlap", "overlap_min"},
    {"with a poor fit to the surfaces", "near_min"},
};

double distance_m(const Pose& T_a, const Pose& T_b) { return (T_a.translation() - T_b.translation()).norm(); }

double quality_of(const ClosureResult& closed) { return closed.overlap * closed.near_share; }

/// Pose at which an alignment starts, and where its result has to be.
struct StartPose {
  Pose T_older_newer = Pose::Identity();
  Pose T_expected = Pose::Identity();
  double reach_m = 0.0;  // largest distance of the result from T_expected
  std::optional<PosePrior> prior;
  Reach reach = Reach::kWide;
};

/// Overlap of the newer submap with the older one, and fit of the overlap to its surfaces. Floors fit wherever a guess
/// is, so upright structure has to fit by itself as well.
/// @param tolerance  factor on the tolerated shares
ClosureResult verify(const SubmapPair& pair, const Pose& T_older_newer, int max_unobserved, double tolerance,
                     const ClosureConfig& config) {
  const double overlap_min = 1.0 - tolerance * (1.0 - config.overlap_min);
  const double near_min = 1.0 - tolerance * (1.0 - config.near_min);
  const ScanFit fit = fit_finely(pair, pair.newer_m, T_older_newer, max_unobserved > 0);
  ClosureResult result;
  result.overlap = static_cast<double>(fit.num_known) / std::max(fit.num_points, 1);
  result.near_share = static_cast<double>(fit.num_near) / std::max(fit.num_known, 1);
  result.verdict = fit.num_degenerate > max_unobserved ? ClosureVerdict::kUnobserved
                   : result.overlap < overlap_min      ? ClosureVerdict::kLowOverlap
                   : result.near_share < near_min      ? ClosureVerdict::kPoorFit
                                                       : ClosureVerdict::kClosed;
  if (!result.closed()) return result;
  result.T_older_newer = T_older_newer;
  result.observed = observed_directions(fit.evidence, fit.num_degenerate);
  if (max_unobserved == 0) return result;  // found by its upright structure
  const ScanFit upright = fit_finely(pair, pair.upright_newer_m, T_older_newer, false);
  if (upright.num_known < static_cast<int>(kMinUpright))
    result.verdict = ClosureVerdict::kTooFlat;
  else if (upright.num_near < near_min * upright.num_known)
    result.verdict = ClosureVerdict::kPoorFit;
  return result;
}

/// With a prior, one direction may stay unobserved: it keeps the guess, and the closure does not constrain it.
ClosureResult align_and_verify(const SubmapPair& pair, const StartPose& start, double tolerance,
                               const ClosureConfig& config) {
  const int max_unobserved = start.prior ? 1 : 0;
  Pose T = start.T_older_newer;
  if (!start.prior) align_height(pair, config.cell_m, T);
  ClosureResult refused;
  if (align(pair, start.prior, start.reach, T) > max_unobserved) {
    refused.verdict = ClosureVerdict::kUnobserved;
    return refused;
  }
  const Matrix3 R_turned = start.T_expected.linear().transpose() * T.linear();
  const double turned_rad = rotation_vector_rad(Eigen::Quaterniond(R_turned)).norm();
  if (distance_m(start.T_expected, T) > start.reach_m || turned_rad > kMaxTurned_deg * kRadPerDeg) {
    refused.verdict = ClosureVerdict::kDiverged;
    return refused;
  }
  return verify(pair, T, max_unobserved, tolerance, config);
}

ClosureResult align_from_grid(const SubmapPair& pair, const CandidatePose& pose, double tolerance,
                              const ClosureConfig& config) {
  return align_and_verify(
      pair, {pose.T_older_newer, pose.T_older_newer, kMaxMovedCells * config.cell_m, std::nullopt, Reach::kWide},
      tolerance, config);
}

/// Where surfaces nearly meet at two places, a wide reach may find the wrong one and a close reach none, so both are
/// tested. Along a wall the surfaces give no gradient, and a wrong guess is not corrected. So the newer submap is
/// shifted along the wall to where most of it fits. If other places fit about as well, the closure does not constrain
/// that direction.
ClosureResult close_near_guess(const SubmapPair& pair, const ClosureCandidate& candidate, const ClosureConfig& config) {
  const Pose& T_guess = candidate.T_older_newer_guess;
  const double reach_m = std::max(candidate.guess_error_m, kMinGuessError_m);
  const PosePrior prior = prior_of(T_guess, reach_m);
  const auto aligned = [&](const Pose& T_start, Reach reach) {
    return align_and_verify(pair, {T_start, T_guess, reach_m, prior, reach}, 1.0, config);
  };
  const ClosureResult wide = aligned(T_guess, Reach::kWide), close = aligned(T_guess, Reach::kClose);
  if (!wide.closed() && !close.closed()) return wide;
  const bool wide_is_better = !close.closed() || (wide.closed() && quality_of(wide) > quality_of(close));
  ClosureResult result = wide_is_better ? wide : close;
  const ClosureResult& other = wide_is_better ? close : wide;
  ShiftedPoses shifts = sample_shifts(pair, result.T_older_newer, reach_m);
  if (other.closed() && quality_of(other) >= config.rival_fit * quality_of(result) &&
      shifts.distance_from_line_m(other.T_older_newer) > kSamePose_m) {
    result.verdict = ClosureVerdict::kAmbiguous;
    return result;
  }
  if (std::abs(shifts.offset_m[shifts.best()]) > kSamePose_m) {
    const ClosureResult along = aligned(shifts.T_older_newer[shifts.best()], Reach::kClose);
    if (along.closed() && quality_of(along) > quality_of(result)) {
      result = along;
      shifts = sample_shifts(pair, result.T_older_newer, reach_m);
    }
  }
  if (result.observed.isIdentity() && shifts.fits_elsewhere())
    result.observed = observed_directions(shifts.evidence, 1);
  return result;
}

/// Refuses a closure when the surfaces fit about as well at another place of the same submap. The other place may have
/// a lower score of the grid: where all bays of an aisle look alike, the place with the largest overlap scores best.
/// Places farther from the guess than the found place and the error of the guess are ignored.
void verify_uniqueness(ClosureSearch& search, const ClosureCandidate& candidate, const SubmapPair& pair,
                       const CandidatePose& best, double tolerance, const ClosureConfig& config,
                       ClosureResult& result) {
  const auto rival = search.best_rival(best, best.candidate, config.rival_examined * best.score);
  if (!search.complete()) result.verdict = ClosureVerdict::kOverBudget;
  if (!search.complete() || !rival) return;
  const Pose& T_guess = candidate.T_older_newer_guess;
  const double reach_m = std::max(distance_m(T_guess, best.T_older_newer) + config.cell_m, candidate.guess_error_m);
  if (distance_m(T_guess, rival->T_older_newer) > reach_m) return;
  const ClosureResult fit = align_from_grid(pair, *rival, tolerance, config);
  if (fit.closed() && quality_of(fit) >= config.rival_fit * quality_of(result))
    result.verdict = ClosureVerdict::kAmbiguous;
}

/// Steps 2 to 4 for the best pose of the grid.
ClosureResult close_at_grid_pose(ClosureSearch& search, const ClosureCandidate& candidate, const SubmapPair& pair,
                                 const CandidatePose& best, const ClosureConfig& config) {
  const double tolerance = candidate.guess_error_m == kNoGuess ? config.unguided_tolerance : 1.0;
  ClosureResult result = align_from_grid(pair, best, tolerance, config);
  const double reach_m = std::max(candidate.guess_error_m, kMinGuessError_m);
  if (result.closed() && distance_m(candidate.T_older_newer_guess, result.T_older_newer) > reach_m)
    result.verdict = ClosureVerdict::kDiverged;
  if (result.closed()) verify_uniqueness(search, candidate, pair, best, tolerance, config, result);
  return result;
}

}  // namespace

ClosureResult find_closure(std::span<const ClosureCandidate> candidates,
                           std::span<const Eigen::Vector3f> points_newer_m, const ClosureConfig& config,
                           const RotationalHistogram* directions_newer) {
  const auto refused = [](ClosureVerdict verdict) {
    ClosureResult result;
    result.verdict = verdict;
    return result;
  };
  const auto upright_newer_m = upright_points_m(points_newer_m, config.cell_m, config.range_max_m);
  std::vector<std::vector<Eigen::Vector3f>> upright_older_m;
  std::size_t most_upright = 0;
  for (const ClosureCandidate& candidate : candidates) {
    upright_older_m.push_back(upright_points_m(candidate.points_older_m, config.cell_m, config.range_max_m));
    most_upright = std::max(most_upright, upright_older_m.back().size());
  }
  if (std::min(most_upright, upright_newer_m.size()) < kMinUpright) return refused(ClosureVerdict::kTooFlat);

  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (candidates[i].guess_error_m > kNearlyRight_m) continue;
    const SubmapPair pair(candidates[i].points_older_m, points_newer_m, upright_newer_m);
    ClosureResult result = close_near_guess(pair, candidates[i], config);
    result.candidate = i;
    if (result.closed() || result.verdict == ClosureVerdict::kAmbiguous) return result;
  }

  ClosureSearch search(candidates, upright_older_m, points_newer_m, upright_newer_m, directions_newer, config);
  const std::optional<CandidatePose> best = search.best_pose(config.score_min);
  bool has_rival = false;
  for (std::size_t i = 0; best && i < candidates.size() && search.complete() && !has_rival; ++i) {
    has_rival = search.best_rival(*best, i, config.rival_score * best->score).has_value();
  }
  ClosureResult result = refused(!search.complete() ? ClosureVerdict::kOverBudget
                                 : !best            ? ClosureVerdict::kNoMatch
                                                    : ClosureVerdict::kAmbiguous);
  if (search.complete() && best && !has_rival) {
    const ClosureCandidate& candidate = candidates[best->candidate];
    const SubmapPair pair(candidate.points_older_m, points_newer_m, upright_newer_m);
    result = close_at_grid_pose(search, candidate, pair, *best, config);
    result.candidate = best->candidate;
  }
  if (best) result.score = best->score;
  result.num_expanded = search.num_expanded();
  return result;
}

void ClosureCounts::append_counters(const std::string& attempts, std::vector<Counter>& counters) const {
  const std::uint64_t num = std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0});
  for (std::size_t i = 0; i < std::size(kRefusals); ++i) {
    counters.push_back({attempts + ' ' + kRefusals[i].reason, counts_[i], num,
                        std::string("global.closures.") + kRefusals[i].setting});
  }
}

void ClosureConfig::visit(ConfigVisitor& v) {
  v.field("cell_m", cell_m, "[m] edge of a cell of the search grid", Range::between(0.1, 5.0));
  v.field("range_max_m", range_max_m, "[m] distance from the submap's center above which points are ignored",
          Range::between(2.0, 200.0));
  v.field("budget", budget, "[-] largest number of nodes of all searches for one submap",
          Range::between(100, 100000000));
  v.field("score_min", score_min, "[-] share of the points that must lie in occupied cells of the search grid",
          Range::probability());
  v.field("overlap_min", overlap_min,
          "[-] share of a submap that the older one must contain; the tolerance is 2/3 as large without a guess",
          Range::probability());
  v.field("near_min", near_min, "[-] share of the overlap that must lie on surfaces; as overlap_min without a guess",
          Range::probability());
}

}  // namespace swiftlet
