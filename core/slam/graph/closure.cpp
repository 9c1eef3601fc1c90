// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/closure.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/slam/graph/branch_and_bound.hpp"
#include "core/slam/matching/scan_to_map.hpp"
#include "core/slam/matching/surface_map.hpp"
#include "core/slam/matching/sweep.hpp"
#include "core/slam/symmetric_eigen.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {
namespace {

constexpr double kFinest_m = 0.01;  // finest surface sigma of a refinement: drift bends each submap a little
constexpr double kUpright_m = 1.0;
constexpr std::size_t kLeastUpright = 40;
// smallest heading difference at which a rival at the same place counts as another pose
constexpr double kRivalHeading_rad = 20.0 * kRadPerDeg;
constexpr double kRivalScore = 0.7;  // lowest score of a rival that is examined, as a share of the best score
// quality (overlap times share of near points) of a rival, relative to the best, that makes a closure ambiguous
constexpr double kRivalFit = 0.8;
constexpr std::size_t kFitted = 5000;   // most points of the newer submap used in a fit; more points do not improve it
constexpr double kNarrowest_m = 1.0;    // smallest search window: two cells of the grid
constexpr double kNearlyRight_m = 0.6;  // largest error of a guess at which its points still match the right surfaces
constexpr double kLeastOff_m = 0.3;     // lower bound of the assumed error of a guess
// Directions with less than this share of the information count as open: normals of a thinned cloud are off by up to 8
// degrees, which alone can produce such a share.
constexpr double kOpenShare = 0.02;
constexpr int kMostOpen = 1, kAllOpen = 6;  // open directions allowed after a guess; all directions of a pose
constexpr double kMoves = 0.1;              // translation [m] per unit step; directions below it are pure rotations
constexpr double kTurnedOff_deg = 1.0;      // attitude error of a guess, one standard deviation
constexpr double kCoarsest_m = 0.3, kFine_m = 0.03;  // surface sigma of the first steps: wide and close
constexpr double kApart_m = 0.1;                     // places farther from each other than this are different
constexpr double kShift_m = 0.15;                    // step along the least constrained direction
// a fit with more than kHolds of the near points, shifted by kHolds_m or more, does not constrain the direction
constexpr double kHolds_m = 0.3, kHolds = 0.95;
constexpr int kRefinements = 8;
constexpr double kStill = 1e-4;  // step below which a refinement has converged [m, rad]
// largest correction by the refinement: somewhat more than a cell of the grid
constexpr double kMovedMost_m = 1.0, kMovedMost_deg = 4.0;

void keep_at_most(std::size_t most, std::vector<Eigen::Vector3f>& points_m) {
  const std::size_t num = points_m.size();
  if (num <= most) return;
  for (std::size_t i = 0; i < most; ++i) points_m[i] = points_m[i * num / most];
  points_m.resize(most);
}

/// Step at which the farthest point moves by less than a cell [Hess et al., ICRA 2016, eq. 7].
double yaw_step_rad(double cell_m, double range_m) {
  const double share = cell_m / std::max(range_m, cell_m);
  return 0.99 * elementary::acos(1.0 - 0.5 * share * share);
}

ScanToMapConfig matching_of(double surface_sigma_m, double open_share = ScanToMapConfig{}.degenerate_share) {
  ScanToMapConfig matching;
  matching.degenerate_share = open_share;
  matching.surface_sigma_m = surface_sigma_m;
  return matching;
}

/// Walls hardly constrain the height. This selects the height at which most points lie on surfaces, floors included.
void settle_height(const SurfaceMap& map, std::span<const Eigen::Vector3f> points_m, double cell_m, Pose& T) {
  const ScanToMapConfig matching = matching_of(0.1);
  const double z_m = T.translation().z();
  double best_m = z_m;
  int most = -1;
  ScanFitter fitter;
  for (const int halves : {0, 1, -1, 2, -2}) {
    T.translation().z() = z_m + 0.5 * cell_m * halves;
    const int near = fitter.fit(map, points_m, T, matching).num_near;
    if (near <= most) continue;
    most = near;
    best_m = T.translation().z();
  }
  T.translation().z() = best_m;
}

/// Prior knowledge of a pose, as information [1/m^2, 1/rad^2].
struct PosePrior {
  Pose T = Pose::Identity();
  Matrix6 information = Matrix6::Zero();
};

PosePrior prior_of(const Pose& T_guess, double off_m) {
  PosePrior prior{T_guess};
  const double sigma_m = std::max(off_m, kLeastOff_m) / 3.0, sigma_rad = kTurnedOff_deg * kRadPerDeg;
  prior.information.diagonal() << Vector3::Constant(1.0 / (sigma_m * sigma_m)),
      Vector3::Constant(1.0 / (sigma_rad * sigma_rad));
  return prior;
}

/// Step by which moved() takes T_from to T_to.
Vector6 step_between(const Pose& T_from, const Pose& T_to) {
  Vector6 step;
  step << T_to.translation() - T_from.translation(),
      rotation_vector_rad(Eigen::Quaterniond(Matrix3(T_from.linear().transpose() * T_to.linear())));
  return step;
}

/// Gauss-Newton on the distances of the points from the surfaces. The first steps include points as far off as a cell
/// of the grid is wide, the last ones only close points.
/// @param prior  constrains the pose in directions that the surfaces leave open; null: no direction may be open
/// @param coarsest_m  surface sigma of the first steps
/// @return number of open directions
int refine(const SurfaceMap& map, std::span<const Eigen::Vector3f> points_m, const PosePrior* prior, double coarsest_m,
           Pose& T) {
  ScanFitter fitter;
  const double open_share = prior == nullptr ? ScanToMapConfig{}.degenerate_share : kOpenShare;
  for (const double sigma_m : {0.3, 0.1, 0.03, kFinest_m}) {
    if (sigma_m > coarsest_m) continue;
    const ScanToMapConfig matching = matching_of(sigma_m, open_share);
    for (int i = 0; i < kRefinements; ++i) {
      const ScanFit fit = fitter.fit(map, points_m, T, matching);
      if (fit.num_degenerate > 0 && prior == nullptr) return fit.num_degenerate;
      PoseEvidence evidence = fit.evidence;
      if (prior != nullptr) {
        evidence.information += prior->information;
        evidence.gradient += prior->information * step_between(prior->T, T);
      }
      const Vector6 step = evidence.information.ldlt().solve(evidence.gradient);
      if (!step.allFinite()) return kAllOpen;
      T = moved(T, -step);
      if (step.cwiseAbs().maxCoeff() < kStill) break;
    }
  }
  return fitter.fit(map, points_m, T, matching_of(kFinest_m, open_share)).num_degenerate;
}

/// Directions of a pose, the least constrained first. A unit step along a direction moves points by 1 m on average:
/// rotations are scaled by the mean lever arm.
struct Directions {
  explicit Directions(const PoseEvidence& evidence) {
    const Matrix6& information = evidence.information;
    const double lever_sq = information.diagonal().tail<3>().sum() / information.diagonal().head<3>().sum();
    scale << Vector3::Ones(), Vector3::Constant(std::sqrt(std::max(lever_sq, 1.0)));
    const Vector6 inverse = scale.cwiseInverse();
    vectors = symmetric_eigen<6>(Matrix6(inverse.asDiagonal() * information * inverse.asDiagonal())).vectors;
  }
  Vector6 step(int i) const { return vectors.col(i).cwiseQuotient(scale); }

  Vector6 scale;
  Matrix6 vectors;  // eigenvectors in scaled steps
};

/// Projection onto the directions of a pose that the evidence constrains.
Matrix6 constrained_directions(const PoseEvidence& evidence, int num_open) {
  if (num_open == 0) return Matrix6::Identity();
  const Directions of(evidence);
  Matrix6 kept = Matrix6::Identity();
  for (int i = 0; i < num_open; ++i) kept -= of.vectors.col(i) * of.vectors.col(i).transpose();
  return of.scale.cwiseInverse().asDiagonal() * kept * of.scale.asDiagonal();
}

/// Search window, no wider than the error of the guess: where bays look alike, the neighboring bay is outside the
/// window.
SearchWindow window_of(const ClosureConfig& config, double guess_off_m = std::numeric_limits<double>::infinity()) {
  const double off_m = std::max(guess_off_m, kNarrowest_m);
  SearchWindow window;
  window.xy_cells = static_cast<int>(std::ceil(std::min(config.window_xy_m, off_m) / config.cell_m));
  window.z_cells = static_cast<int>(std::ceil(std::min(config.window_z_m, off_m) / config.cell_m));
  window.yaw_rad = config.window_yaw_deg * kRadPerDeg;
  window.yaw_step_rad = yaw_step_rad(config.cell_m, config.range_max_m);
  return window;
}

/// A flag for each heading of the window: true where the histograms agree.
std::vector<std::uint8_t> likely_headings(const RotationalHistogram& of_older, const RotationalHistogram& of_newer,
                                          double yaw_guess_rad, const SearchWindow& window, double least) {
  std::vector<std::uint8_t> allowed(num_yaws(window));
  for (int i = 0; i < num_yaws(window); ++i) {
    const double yaw_rad = yaw_guess_rad + yaw_offset_rad(window, i);
    allowed[i] = of_newer.similarity(of_older, yaw_rad) >= least ? 1 : 0;
  }
  return allowed;
}

SurfaceMap surfaces_of(std::span<const Eigen::Vector3f> points_m) {
  SurfaceMap surfaces{SurfaceMapConfig{}};
  std::vector<Vector3> exact_m(points_m.size());
  for (std::size_t i = 0; i < exact_m.size(); ++i) exact_m[i] = points_m[i].cast<double>();
  surfaces.insert(exact_m, Vector3::Zero());
  return surfaces;
}

/// The cloud of the newer submap, and a subset of it for fits.
struct NewerCloud {
  explicit NewerCloud(std::span<const Eigen::Vector3f> points_m)
      : all_m(points_m), fitted_m(points_m.begin(), points_m.end()) {
    keep_at_most(kFitted, fitted_m);
  }
  std::span<const Eigen::Vector3f> all_m;
  std::vector<Eigen::Vector3f> fitted_m;
};

/// Poses of the newer submap, shifted along the direction that the surfaces constrain least.
struct ShiftedPoses {
  PoseEvidence evidence;  // at the unshifted pose
  Vector6 step;           // direction of the shifts
  std::vector<Pose> T_older_newer;
  std::vector<double> offset_m;
  std::vector<int> num_near;  // number of points on surfaces

  /// Distance of another pose from the line of the shifted poses. A pure rotation has no line: there it is the distance
  /// from the unshifted pose.
  double off_line_m(const Pose& T) const {
    const Vector3 off_m = T.translation() - T_older_newer.front().translation();
    if (step.head<3>().norm() < kMoves) return off_m.norm();
    const Vector3 along = step.head<3>().normalized();
    return (off_m - off_m.dot(along) * along).norm();
  }
};

/// @param reach_m  largest shift to either side; poses are sampled from the unshifted one outward
ShiftedPoses sample_shifts(const SurfaceMap& surfaces, const NewerCloud& newer, const Pose& T_older_newer,
                           double reach_m) {
  ENSURE(std::isfinite(reach_m), reach_m);
  ScanFitter fitter;
  const auto fit_at = [&](const Pose& T) {
    return fitter.fit(surfaces, newer.fitted_m, T, matching_of(kFinest_m, kOpenShare));
  };
  const ScanFit fit = fit_at(T_older_newer);
  ShiftedPoses shifts{fit.evidence, Directions(fit.evidence).step(0), {T_older_newer}, {0.0}, {fit.num_near}};
  const int num_steps = static_cast<int>(std::ceil(reach_m / kShift_m));
  for (int i = 1; i <= num_steps; ++i) {
    for (const double offset_m : {i * kShift_m, -i * kShift_m}) {
      shifts.T_older_newer.push_back(moved(T_older_newer, offset_m * shifts.step));
      shifts.offset_m.push_back(offset_m);
      shifts.num_near.push_back(fit_at(shifts.T_older_newer.back()).num_near);
    }
  }
  return shifts;
}

/// Does the submap fit about as well after a shift? Then the apparent constraint along that direction comes from
/// errors of normals, or from ledges that meet other ledges.
bool fits_elsewhere(const ShiftedPoses& shifts) {
  for (std::size_t i = 1; i < shifts.offset_m.size(); ++i) {
    if (std::abs(shifts.offset_m[i]) >= kHolds_m && shifts.num_near[i] > kHolds * shifts.num_near.front()) return true;
  }
  return false;
}

/// Final checks: overlap of the newer submap with the older one, and fit of the overlapping points to its surfaces.
/// @param num_open  directions that may be left open
void check_fit(const SurfaceMap& surfaces, const NewerCloud& newer, const Pose& T_older_newer, int num_open,
               const ClosureConfig& config, ClosureResult& result) {
  const double open_share = num_open == 0 ? ScanToMapConfig{}.degenerate_share : kOpenShare;
  const ScanFit fit = fit_scan(surfaces, newer.all_m, T_older_newer, matching_of(kFinest_m, open_share));
  result.overlap = static_cast<double>(fit.num_known) / std::max(fit.num_points, 1);
  result.near_share = static_cast<double>(fit.num_near) / std::max(fit.num_known, 1);
  result.verdict = fit.num_degenerate > num_open         ? ClosureVerdict::kOpen
                   : result.overlap < config.overlap_min ? ClosureVerdict::kNoOverlap
                   : result.near_share < config.near_min ? ClosureVerdict::kDoesNotFit
                                                         : ClosureVerdict::kClosed;
  if (result.verdict != ClosureVerdict::kClosed) return;
  result.T_older_newer = T_older_newer;
  result.constrained = constrained_directions(fit.evidence, fit.num_degenerate);
}

/// Refines a match of the grid on the surfaces of the older submap and makes the final checks.
void settle(const SurfaceMap& surfaces, const NewerCloud& newer, const Pose& T_older_newer_grid,
            const ClosureConfig& config, ClosureResult& result) {
  Pose T = T_older_newer_grid;
  settle_height(surfaces, newer.fitted_m, config.cell_m, T);
  const bool open = refine(surfaces, newer.fitted_m, nullptr, kCoarsest_m, T) > 0;
  const Pose by = T_older_newer_grid.inverse() * T;
  const double turned_rad = rotation_vector_rad(Eigen::Quaterniond(Matrix3(by.linear()))).norm();
  if (open) {
    result.verdict = ClosureVerdict::kOpen;
    return;
  }
  if (by.translation().norm() > kMovedMost_m || turned_rad > kMovedMost_deg * kRadPerDeg) {
    result.verdict = ClosureVerdict::kMoved;
    return;
  }
  check_fit(surfaces, newer, T, 0, config, result);
}

double distance_m(const Pose& T_a, const Pose& T_b) { return (T_a.translation() - T_b.translation()).norm(); }

/// Refines a nearly correct guess on the surfaces. One direction may stay open: it keeps the guess, and the closure
/// does not constrain it. Floors fit wherever the guess is, so upright structure has to fit by itself as well.
/// @param T_start  initial pose of the refinement
ClosureResult settle_from_guess(const SurfaceMap& surfaces, const NewerCloud& newer,
                                std::span<const Eigen::Vector3f> upright_newer_m, const PosePrior& prior,
                                const Pose& T_start, double off_m, double coarsest_m, const ClosureConfig& config) {
  ClosureResult result;
  Pose T = T_start;
  if (refine(surfaces, newer.fitted_m, &prior, coarsest_m, T) > kMostOpen)
    result.verdict = ClosureVerdict::kOpen;
  else if (distance_m(prior.T, T) > off_m)
    result.verdict = ClosureVerdict::kMoved;
  else
    check_fit(surfaces, newer, T, kMostOpen, config, result);
  if (result.verdict != ClosureVerdict::kClosed) return result;
  const ScanFit upright = fit_scan(surfaces, upright_newer_m, T, matching_of(kFinest_m));
  if (upright.num_known < static_cast<int>(kLeastUpright))
    result.verdict = ClosureVerdict::kTooFlat;
  else if (upright.num_near < config.near_min * upright.num_known)
    result.verdict = ClosureVerdict::kDoesNotFit;
  return result;
}

double quality_of(const ClosureResult& closed) { return closed.overlap * closed.near_share; }

/// Where surfaces nearly meet at two places, a wide reach may find the wrong one and a short reach none, so both are
/// tested. Along a wall the surfaces give no gradient, and a wrong guess stays where it is. So the newer submap is
/// shifted along the wall to where most of it fits. If other places fit about as well, the closure does not constrain
/// that direction.
ClosureResult settle_near_guess(const SurfaceMap& surfaces, const NewerCloud& newer,
                                std::span<const Eigen::Vector3f> upright_newer_m, const Pose& T_guess, double off_m,
                                const ClosureConfig& config) {
  const double reach_m = std::max(off_m, kLeastOff_m);
  const PosePrior prior = prior_of(T_guess, off_m);
  const auto settled = [&](const Pose& T_start, double coarsest_m) {
    return settle_from_guess(surfaces, newer, upright_newer_m, prior, T_start, reach_m, coarsest_m, config);
  };
  const auto is_closed = [](const ClosureResult& r) { return r.verdict == ClosureVerdict::kClosed; };
  const ClosureResult wide = settled(T_guess, kCoarsest_m), close = settled(T_guess, kFine_m);
  if (!is_closed(wide) && !is_closed(close)) return wide;
  const bool wide_is_better = !is_closed(close) || (is_closed(wide) && quality_of(wide) > quality_of(close));
  ClosureResult result = wide_is_better ? wide : close;
  const ClosureResult& other = wide_is_better ? close : wide;
  ShiftedPoses shifts = sample_shifts(surfaces, newer, result.T_older_newer, reach_m);
  if (is_closed(other) && quality_of(other) >= kRivalFit * quality_of(result) &&
      shifts.off_line_m(other.T_older_newer) > kApart_m) {
    result.verdict = ClosureVerdict::kRival;
    return result;
  }
  const auto best = std::max_element(shifts.num_near.begin(), shifts.num_near.end()) - shifts.num_near.begin();
  if (std::abs(shifts.offset_m[best]) > kApart_m) {
    const ClosureResult along = settled(shifts.T_older_newer[best], kFine_m);
    if (is_closed(along) && quality_of(along) > quality_of(result)) {
      result = along;
      shifts = sample_shifts(surfaces, newer, result.T_older_newer, reach_m);
    }
  }
  if (result.constrained.isIdentity() && fits_elsewhere(shifts))
    result.constrained = constrained_directions(shifts.evidence, 1);
  return result;
}

/// Inputs of a search: clouds, guess and window.
struct CandidateSearch {
  const OccupancyPyramid& pyramid;
  std::span<const Eigen::Vector3f> upright_newer_m;
  const NewerCloud& newer;
  Pose T_guess;
  const SearchWindow& window;
  std::span<const std::uint8_t> headings;
};

/// Marks a closure as ambiguous when the surfaces fit about as well at another place. The other place may have a lower
/// score of the grid: where all bays of an aisle look alike, the place with the largest overlap scores best. Places
/// farther from the guess than both this one and the error of the guess are ignored.
void check_rivals(const CandidateSearch& search, const SurfaceMap& surfaces, const GridMatch& best, double guess_off_m,
                  const ClosureConfig& config, ClosureResult& result) {
  const Excluded excluded{best.T_map_cloud, config.rival_distance_m};
  const SearchResult found = search_best_pose(search.pyramid, search.upright_newer_m, search.T_guess, search.window,
                                              kRivalScore * best.score, config.budget, search.headings, &excluded);
  result.num_expanded += found.num_expanded;
  if (!found.complete) result.verdict = ClosureVerdict::kNotSearched;
  if (!found.complete || !found.best) return;
  const double reach_m = std::max(distance_m(search.T_guess, best.T_map_cloud) + config.cell_m, guess_off_m);
  if (distance_m(search.T_guess, found.best->T_map_cloud) > reach_m) return;
  ClosureResult rival;
  settle(surfaces, search.newer, found.best->T_map_cloud, config, rival);
  const bool fits_as_well = rival.verdict == ClosureVerdict::kClosed &&
                            rival.overlap * rival.near_share >= kRivalFit * result.overlap * result.near_share;
  if (fits_as_well) result.verdict = ClosureVerdict::kRival;
}

}  // namespace

std::vector<Eigen::Vector3f> upright_points_m(std::span<const Eigen::Vector3f> points_m, double cell_m,
                                              double range_max_m) {
  const auto column_of = [&](const Eigen::Vector3f& p) {
    return std::pair(static_cast<int>(std::floor(p.x() / cell_m)), static_cast<int>(std::floor(p.y() / cell_m)));
  };
  const auto is_near = [&](const Eigen::Vector3f& p) { return p.head<2>().norm() <= range_max_m; };
  std::map<std::pair<int, int>, std::pair<float, float>> heights;
  for (const Eigen::Vector3f& p : points_m) {
    if (!is_near(p)) continue;
    const auto [it, fresh] = heights.try_emplace(column_of(p), p.z(), p.z());
    if (!fresh) it->second = {std::min(it->second.first, p.z()), std::max(it->second.second, p.z())};
  }
  std::vector<Eigen::Vector3f> upright_m;
  upright_m.reserve(points_m.size());
  for (const Eigen::Vector3f& p : points_m) {
    if (!is_near(p)) continue;
    const auto& [low_m, high_m] = heights.at(column_of(p));
    if (high_m - low_m >= kUpright_m) upright_m.push_back(p);
  }
  std::vector<std::uint32_t> kept;
  kept.reserve(upright_m.size());
  VoxelThinner().thin(upright_m, static_cast<float>(cell_m), kept);
  for (std::size_t i = 0; i < kept.size(); ++i) upright_m[i] = upright_m[kept[i]];
  upright_m.resize(kept.size());
  return upright_m;
}

ClosureResult find_closure(std::span<const Eigen::Vector3f> points_older_m,
                           std::span<const Eigen::Vector3f> points_newer_m, const Pose& T_older_newer_guess,
                           const ClosureConfig& config, double guess_off_m) {
  ClosureResult result;
  const auto refused = [&](ClosureVerdict reason) {
    result.verdict = reason;
    return result;
  };
  const std::vector<Eigen::Vector3f> older_m = upright_points_m(points_older_m, config.cell_m, config.range_max_m);
  std::vector<Eigen::Vector3f> newer_m = upright_points_m(points_newer_m, config.cell_m, config.range_max_m);
  if (std::min(older_m.size(), newer_m.size()) < kLeastUpright) return refused(ClosureVerdict::kTooFlat);
  const NewerCloud cloud(points_newer_m);
  std::optional<SurfaceMap> surfaces;
  if (guess_off_m <= kNearlyRight_m) {
    surfaces = surfaces_of(points_older_m);
    const ClosureResult met = settle_near_guess(*surfaces, cloud, newer_m, T_older_newer_guess, guess_off_m, config);
    if (met.verdict == ClosureVerdict::kClosed || met.verdict == ClosureVerdict::kRival) return met;
  }
  keep_at_most(config.points, newer_m);
  const SearchWindow window = window_of(config, guess_off_m);
  const std::vector<std::uint8_t> allowed =
      likely_headings(RotationalHistogram(points_older_m), RotationalHistogram(points_newer_m),
                      yaw_of(T_older_newer_guess.linear()), window, config.histogram_min);
  const OccupancyPyramid pyramid(older_m, config.cell_m, config.levels);
  SearchResult found =
      search_best_pose(pyramid, newer_m, T_older_newer_guess, window, config.score_min, config.budget, allowed);
  result.num_expanded = found.num_expanded;
  if (!found.complete) return refused(ClosureVerdict::kNotSearched);
  if (!found.best) return refused(ClosureVerdict::kNoMatch);
  const GridMatch best = *found.best;
  result.score = best.score;
  const Excluded excluded{best.T_map_cloud, config.rival_distance_m};
  found = search_best_pose(pyramid, newer_m, T_older_newer_guess, window, config.rival_share * best.score,
                           config.budget, allowed, &excluded);
  result.num_expanded += found.num_expanded;
  if (!found.complete) return refused(ClosureVerdict::kNotSearched);
  if (found.best) return refused(ClosureVerdict::kRival);
  if (!surfaces) surfaces = surfaces_of(points_older_m);
  settle(*surfaces, cloud, best.T_map_cloud, config, result);
  if (result.verdict != ClosureVerdict::kClosed) return result;
  if (distance_m(T_older_newer_guess, result.T_older_newer) > std::max(guess_off_m, kLeastOff_m)) {
    return refused(ClosureVerdict::kMoved);
  }
  check_rivals({pyramid, newer_m, cloud, T_older_newer_guess, window, allowed}, *surfaces, best, guess_off_m, config,
               result);
  return result;
}

MapMatch find_in_map(std::span<const MapPart> parts, std::span<const Eigen::Vector3f> points_newer_m,
                     const ClosureConfig& config, const RotationalHistogram* directions) {
  MapMatch match;
  ClosureResult& result = match.result;
  const auto refused = [&](ClosureVerdict reason) {
    result.verdict = reason;
    return match;
  };
  std::vector<Eigen::Vector3f> cloud_m = upright_points_m(points_newer_m, config.cell_m, config.range_max_m);
  if (cloud_m.size() < kLeastUpright) return refused(ClosureVerdict::kTooFlat);
  keep_at_most(config.points, cloud_m);
  const RotationalHistogram of_cloud = directions != nullptr ? *directions : RotationalHistogram(points_newer_m);
  const SearchWindow window = window_of(config);

  struct Place {
    std::vector<Eigen::Vector3f> upright_m;
    std::vector<std::uint8_t> headings;
  };
  std::vector<Place> places(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    places[i].upright_m = upright_points_m(parts[i].points_part_m, config.cell_m, config.range_max_m);
    const RotationalHistogram of_part =
        parts[i].directions != nullptr ? *parts[i].directions : RotationalHistogram(parts[i].points_part_m);
    places[i].headings = likely_headings(of_part, of_cloud, 0.0, window, config.histogram_min);
  }
  // Two passes: the best match, then rivals of nearly the same score.
  std::optional<GridMatch> best;
  Pose T_map_cloud = Pose::Identity();
  for (const bool for_rivals : {false, true}) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (places[i].upright_m.size() < kLeastUpright) continue;
      const Excluded excluded{parts[i].T_map_part.inverse() * T_map_cloud, config.rival_distance_m, kRivalHeading_rad};
      double least = best ? std::max(config.score_min, best->score) : config.score_min;
      if (for_rivals) least = config.rival_share * best->score;
      const SearchResult found = search_best_pose(
          OccupancyPyramid(places[i].upright_m, config.cell_m, config.levels), cloud_m, Pose::Identity(), window, least,
          config.budget - result.num_expanded, places[i].headings, for_rivals ? &excluded : nullptr);
      result.num_expanded += found.num_expanded;
      if (!found.complete) return refused(ClosureVerdict::kNotSearched);
      if (!found.best) continue;
      if (for_rivals) return refused(ClosureVerdict::kRival);
      if (best && found.best->score <= best->score) continue;
      best = found.best;
      match.part = i;
      T_map_cloud = parts[i].T_map_part * best->T_map_cloud;
    }
    if (!best) return refused(ClosureVerdict::kNoMatch);
    result.score = best->score;
  }
  const SurfaceMap surfaces = surfaces_of(parts[match.part].points_part_m);
  const NewerCloud newer(points_newer_m);
  settle(surfaces, newer, best->T_map_cloud, config, result);
  if (result.verdict == ClosureVerdict::kClosed) {
    const Place& place = places[match.part];
    const OccupancyPyramid pyramid(place.upright_m, config.cell_m, config.levels);
    check_rivals({pyramid, cloud_m, newer, Pose::Identity(), window, place.headings}, surfaces, *best,
                 std::numeric_limits<double>::infinity(), config, result);
  }
  return match;
}

ClosureConfig global_closure_config() {
  ClosureConfig config;
  config.window_xy_m = 8.0;
  config.window_z_m = 3.0;
  config.window_yaw_deg = 180.0;
  config.budget = 3000000;
  config.score_min = 0.6;
  config.overlap_min = 0.6;
  config.near_min = 0.8;
  return config;
}

ClosureConfig locating_config() {
  ClosureConfig config = global_closure_config();
  config.score_min = 0.5;
  return config;
}

void ClosureConfig::visit(ConfigVisitor& v) {
  v.field("cell_m", cell_m, "[m] edge of a cell of the search grid", Range::between(0.1, 5.0));
  v.field("levels", levels, "[-] levels of the search grid, each twice as coarse as the one before",
          Range::between(1, 8));
  v.field("points", points, "[-] most points of the newer submap used in the search", Range::between(50, 5000));
  v.field("range_max_m", range_max_m, "[m] points farther from the submap's center are left out",
          Range::between(2.0, 200.0));
  v.field("budget", budget, "[-] most nodes of one search", Range::between(100, 100000000));
}

}  // namespace swiftlet
