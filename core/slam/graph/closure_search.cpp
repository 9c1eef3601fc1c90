// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/closure_search.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/slam/matching/sweep.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// Height of a column from which its points are upright structure [m]. Lower values let vegetation and curbs in.
constexpr double kMinHeight_m = 1.0;
// [cells] Smallest half width of the window, for guesses with smaller errors. Larger values search longer.
constexpr double kMinCells = 2.0;
// [-] Vertical half width of the window as a share of the horizontal one: gravity is known, so height drifts less.
// Larger values search longer.
constexpr double kVerticalShare = 1.0 / 3.0;

/// Step at which the farthest point moves by less than a cell [Hess et al., ICRA 2016, eq. 7].
double yaw_step_rad(double cell_m, double range_m) {
  const double share = cell_m / std::max(range_m, cell_m);
  return 0.99 * elementary::acos(1.0 - 0.5 * share * share);
}

/// The window is no wider than the error of the guess: where bays look alike, the neighboring bay is outside.
SearchWindow window_of(const ClosureCandidate& candidate, const ClosureConfig& config) {
  const double least_m = kMinCells * config.cell_m;
  const double radius_m = std::min(config.search_radius_m, std::max(candidate.guess_error_m, least_m));
  const double height_m = std::max(kVerticalShare * radius_m, least_m);
  SearchWindow window;
  window.xy_cells = static_cast<int>(std::ceil(radius_m / config.cell_m));
  window.z_cells = static_cast<int>(std::ceil(height_m / config.cell_m));
  window.yaw_rad = candidate.guess_error_m == kNoGuess ? kPi : config.guess_yaw_error_deg * kRadPerDeg;
  window.yaw_step_rad = yaw_step_rad(config.cell_m, config.range_max_m);
  return window;
}

/// A flag for each heading of the window: true where the histograms agree.
std::vector<std::uint8_t> likely_headings(const RotationalHistogram& of_older, const RotationalHistogram& of_newer,
                                          double yaw_guess_rad, const SearchWindow& window, double similarity_min) {
  std::vector<std::uint8_t> likely(static_cast<std::size_t>(num_yaws(window)));
  for (int i = 0; i < num_yaws(window); ++i) {
    const double yaw_rad = yaw_guess_rad + yaw_offset_rad(window, i);
    likely[static_cast<std::size_t>(i)] = of_newer.similarity(of_older, yaw_rad) >= similarity_min ? 1 : 0;
  }
  return likely;
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
    if (high_m - low_m >= kMinHeight_m) upright_m.push_back(p);
  }
  std::vector<std::uint32_t> kept;
  kept.reserve(upright_m.size());
  VoxelThinner().thin(upright_m, static_cast<float>(cell_m), kept);
  for (std::size_t i = 0; i < kept.size(); ++i) upright_m[i] = upright_m[kept[i]];
  upright_m.resize(kept.size());
  return upright_m;
}

void keep_at_most(std::size_t most, std::vector<Eigen::Vector3f>& points_m) {
  const std::size_t num = points_m.size();
  if (num <= most) return;
  for (std::size_t i = 0; i < most; ++i) points_m[i] = points_m[i * num / most];
  points_m.resize(most);
}

ClosureSearch::ClosureSearch(std::span<const ClosureCandidate> candidates,
                             std::span<const std::vector<Eigen::Vector3f>> upright_older_m,
                             std::span<const Eigen::Vector3f> points_newer_m,
                             std::span<const Eigen::Vector3f> upright_newer_m,
                             const RotationalHistogram* directions_newer, const ClosureConfig& config)
    : config_(config),
      candidates_(candidates),
      upright_older_m_(upright_older_m),
      searched_m_(upright_newer_m.begin(), upright_newer_m.end()) {
  keep_at_most(static_cast<std::size_t>(config.max_points), searched_m_);
  const RotationalHistogram of_newer =
      directions_newer != nullptr ? *directions_newer : RotationalHistogram(points_newer_m);
  for (const ClosureCandidate& candidate : candidates) {
    const RotationalHistogram of_older =
        candidate.directions != nullptr ? *candidate.directions : RotationalHistogram(candidate.points_older_m);
    windows_.push_back(window_of(candidate, config));
    likely_headings_.push_back(likely_headings(of_older, of_newer, yaw_of(candidate.T_older_newer_guess.linear()),
                                               windows_.back(), config.heading_similarity_min));
  }
}

std::optional<CandidatePose> ClosureSearch::search(std::size_t candidate, double score_min, const Excluded* excluded) {
  if (upright_older_m_[candidate].size() < kMinUpright) return std::nullopt;
  if (!pyramid_ || pyramid_of_ != candidate) {
    pyramid_.emplace(upright_older_m_[candidate], config_.cell_m, config_.levels);
    pyramid_of_ = candidate;
  }
  const SearchResult found =
      search_best_pose(*pyramid_, searched_m_, candidates_[candidate].T_older_newer_guess, windows_[candidate],
                       score_min, config_.budget - num_expanded_, likely_headings_[candidate], excluded);
  num_expanded_ += found.num_expanded;
  complete_ = complete_ && found.complete;
  if (!found.best) return std::nullopt;
  return CandidatePose{candidate, found.best->T_map_cloud, found.best->score};
}

std::optional<CandidatePose> ClosureSearch::best_pose(double score_min) {
  std::optional<CandidatePose> best;
  for (std::size_t i = 0; i < candidates_.size() && complete_; ++i) {
    const std::optional<CandidatePose> found = search(i, best ? std::max(score_min, best->score) : score_min, nullptr);
    if (found && (!best || found->score > best->score)) best = found;
  }
  return best;
}

std::optional<CandidatePose> ClosureSearch::best_rival(const CandidatePose& best, std::size_t candidate,
                                                       double score_min) {
  const Pose T_map_newer = candidates_[best.candidate].T_map_older * best.T_older_newer;
  const Excluded excluded{candidates_[candidate].T_map_older.inverse() * T_map_newer, config_.rival_distance_m,
                          config_.rival_heading_deg * kRadPerDeg};
  return search(candidate, score_min, &excluded);
}

}  // namespace swiftlet
