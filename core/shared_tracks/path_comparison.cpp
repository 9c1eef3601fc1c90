// SPDX-License-Identifier: BSD-3-Clause
#include "core/shared_tracks/path_comparison.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/shared_tracks/level_alignment.hpp"

namespace swiftlet {
namespace {

/// [-] Largest number of pairs of a fit: more than 30 paths give in window_s, so that no pair is dropped.
constexpr int kFitWindow = 1000;

/// RMS horizontal distance of a path from the best-fitting straight motion at constant velocity.
double bend_m(std::span<const Vector3> p_m, std::span<const double> t_s) {
  const auto n = static_cast<double>(p_m.size());
  Vector3 mean_m = Vector3::Zero();
  double mean_s = 0.0;
  for (std::size_t i = 0; i < p_m.size(); ++i) {
    mean_m += p_m[i] / n;
    mean_s += t_s[i] / n;
  }
  Vector3 cross_sum = Vector3::Zero();
  double time_sq = 0.0;
  for (std::size_t i = 0; i < p_m.size(); ++i) {
    cross_sum += (t_s[i] - mean_s) * (p_m[i] - mean_m);
    time_sq += (t_s[i] - mean_s) * (t_s[i] - mean_s);
  }
  const Vector3 v_mps = time_sq > 0.0 ? Vector3(cross_sum / time_sq) : Vector3::Zero();
  double residual_sq = 0.0;
  for (std::size_t i = 0; i < p_m.size(); ++i) {
    residual_sq += (p_m[i] - mean_m - (t_s[i] - mean_s) * v_mps).head<2>().squaredNorm();
  }
  return std::sqrt(residual_sq / n);
}

/// RMS horizontal distance of the positions from their mean.
double spread_m(std::span<const Vector3> p_m) {
  Vector3 mean_m = Vector3::Zero();
  for (const Vector3& p : p_m) mean_m += p / static_cast<double>(p_m.size());
  double sum = 0.0;
  for (const Vector3& p : p_m) sum += (p - mean_m).head<2>().squaredNorm();
  return std::sqrt(sum / static_cast<double>(p_m.size()));
}

RelativeAlignmentConfig fit_of(const FrameLinkConfig& config) {
  RelativeAlignmentConfig fit;
  fit.window_size = kFitWindow;
  fit.window_step_m = 0.0;  // keeps pairs of several objects at one instant, and pairs of hovering observers
  fit.residual_sigma_max = config.residual_sigma_max;
  fit.min_spread_m = config.min_spread_m;
  fit.heading_sigma_max_deg = config.heading_sigma_max_deg;
  return fit;
}

}  // namespace

void PathComparison::list(const ObserverHistory& own, const ObserverHistory& other) {
  const auto paths_of = [](const ObserverHistory& history, std::vector<const SampledPath*>& paths) {
    paths.assign(1, &history.self());
    for (const ObserverHistory::Seen& seen : history.seen()) paths.push_back(&seen.path);
  };
  paths_of(own, own_paths_);
  paths_of(other, other_paths_);
}

std::optional<FrameAlignment> PathComparison::find(const OtherMotion& anchor) const {
  std::vector<Match> matches;
  for (std::size_t a = 0; a < own_paths_.size(); ++a) {
    for (std::size_t b = a == 0 ? 1 : 0; b < other_paths_.size(); ++b) {
      if (auto found = match(a, b, anchor)) matches.push_back(std::move(*found));
    }
  }
  if (matches.empty()) return std::nullopt;
  for (Match& candidate : matches) find_support(candidate, anchor);
  const auto best = std::max_element(matches.begin(), matches.end(), [](const Match& m, const Match& n) {
    return m.pairs.size() != n.pairs.size() ? m.pairs.size() < n.pairs.size() : m.bends < n.bends;
  });
  const bool is_unambiguous = best->duration_s >= config_.alone_s && best->bends >= config_.alone_sigmas;
  if (best->pairs.size() == 1 && !is_unambiguous) return std::nullopt;
  const bool is_ambiguous = std::any_of(matches.begin(), matches.end(), [&](const Match& m) {
    return m.pairs.size() >= best->pairs.size() &&
           squared_sigmas_between(m.alignment, best->alignment) > kDisagreement_sigma_sq;
  });
  if (is_ambiguous) return std::nullopt;

  std::vector<AlignmentPair> pairs;
  for (const auto& [a, b] : best->pairs) append_pairs(a, b, best->alignment.yaw_rad, pairs);
  std::stable_sort(pairs.begin(), pairs.end(), [](const auto& p, const auto& q) { return p.t < q.t; });
  RelativeAlignment fit(fit_of(config_), drift_config_);
  for (const AlignmentPair& pair : pairs) fit.push(pair);
  return fit.fit(anchor, {});
}

/// Adds to the match further pairs of paths that its alignment maps onto each other, each path in one pair at most.
void PathComparison::find_support(Match& match, const OtherMotion& anchor) const {
  match.pairs.assign(1, {match.own, match.other});
  std::vector<char> other_taken(other_paths_.size(), 0);
  other_taken[match.other] = 1;
  for (std::size_t a = 0; a < own_paths_.size(); ++a) {
    if (a == match.own) continue;
    for (std::size_t b = a == 0 ? 1 : 0; b < other_paths_.size(); ++b) {
      if (other_taken[b] || !supports(a, b, match.alignment, anchor)) continue;
      match.pairs.emplace_back(a, b);
      other_taken[b] = 1;
      break;
    }
  }
}

/// True if the alignment maps the other path onto the own one, straight or curved, over at least support_s.
bool PathComparison::supports(std::size_t own, std::size_t other, const FrameAlignment& alignment,
                              const OtherMotion& anchor) const {
  const Matrix3 R = turn_about_up(alignment.yaw_rad);
  double residual_sigmas_sq = 0.0;  // sum over samples and axes
  double variance_m2 = 0.0;         // sum over samples of the mean over axes
  int count = 0;
  TimeNs first = 0, last = 0;
  for (const PathSample& s : other_paths_[other]->samples()) {
    const auto seen = own_paths_[own]->at(s.t, config_.gap_max_s);
    if (!seen) continue;
    const Flown since = anchor.flown - sum_of(seen->flown, s.flown);
    const double extra_m2 = config_.sigma_common_m * config_.sigma_common_m + drift_.position_variance_m2(since);
    Eigen::Matrix<double, 3, 4> J;
    J << Matrix3::Identity(), up_cross(R * (s.p_local_m - alignment.anchor_other_m));
    const Matrix3 S = seen->covariance + R * s.covariance * R.transpose() + extra_m2 * Matrix3::Identity() +
                      J * alignment.covariance * J.transpose();
    const Vector3 residual_m = seen->p_local_m - alignment.point(s.p_local_m);
    residual_sigmas_sq += residual_m.dot(S.llt().solve(residual_m));
    variance_m2 += S.trace() / 3.0;
    if (count++ == 0) first = s.t;
    last = s.t;
  }
  return count >= RelativeAlignmentConfig{}.min_pairs && last - first >= from_seconds(config_.support_s) &&
         residual_sigmas_sq <= 3.0 * count * config_.residual_sigma_max * config_.residual_sigma_max &&
         variance_m2 <= count * config_.support_sigma_m * config_.support_sigma_m;
}

/// Appends pairs of simultaneous positions on both paths, from the newest back. They are at least interval_s apart, so
/// that their errors are independent.
void PathComparison::append_pairs(std::size_t own, std::size_t other, double yaw_rad,
                                  std::vector<AlignmentPair>& pairs) const {
  const Matrix3 R = turn_about_up(yaw_rad);
  const double common_sq = config_.sigma_common_m * config_.sigma_common_m;
  const std::size_t first = pairs.size();
  TimeNs next = std::numeric_limits<TimeNs>::max();
  const std::span<const PathSample> samples = other_paths_[other]->samples();
  for (auto s = samples.rbegin(); s != samples.rend(); ++s) {
    if (s->t > next) continue;
    const auto seen = own_paths_[own]->at(s->t, config_.gap_max_s);
    if (!seen) continue;
    next = s->t - from_seconds(config_.interval_s);
    pairs.push_back({s->t, seen->p_local_m,
                     seen->covariance + R * s->covariance * R.transpose() + common_sq * Matrix3::Identity(),
                     s->p_local_m, s->v_local_mps, 0.0, sum_of(seen->flown, s->flown)});
  }
  std::reverse(pairs.begin() + static_cast<std::ptrdiff_t>(first), pairs.end());
}

/// Aligns one pair of paths by itself. Nothing if the own path is too short, straight or uncertain, or if the paths
/// differ.
std::optional<PathComparison::Match> PathComparison::match(std::size_t own, std::size_t other,
                                                           const OtherMotion& anchor) const {
  std::vector<Vector3> local_m, other_m;
  std::vector<double> weights, t_s;
  std::vector<Matrix3> covariance_local, covariance_other;
  for (const PathSample& s : other_paths_[other]->samples()) {
    const auto seen = own_paths_[own]->at(s.t, config_.gap_max_s);
    if (!seen) continue;
    const Flown since = anchor.flown - sum_of(seen->flown, s.flown);
    const double extra_m2 = config_.sigma_common_m * config_.sigma_common_m + drift_.position_variance_m2(since);
    local_m.push_back(seen->p_local_m);
    other_m.push_back(s.p_local_m);
    t_s.push_back(to_seconds(s.t - anchor.t));
    covariance_local.push_back(seen->covariance + extra_m2 * Matrix3::Identity());
    covariance_other.push_back(s.covariance);
    weights.push_back(3.0 / (covariance_local.back().trace() + s.covariance.trace()));
  }
  if (static_cast<int>(weights.size()) < config_.min_samples) return std::nullopt;
  const double deviation_m = bend_m(local_m, t_s);
  if (spread_m(local_m) < config_.min_spread_m || deviation_m < config_.min_bend_m) return std::nullopt;
  double variance_m2 = 0.0;  // mean variance per axis
  for (const double weight : weights) variance_m2 += 1.0 / weight / static_cast<double>(weights.size());
  const double bends = deviation_m / std::sqrt(variance_m2);
  if (bends < config_.bend_sigmas) return std::nullopt;
  const auto closed = align_in_closed_form(local_m, other_m, weights);
  if (!closed) return std::nullopt;
  const Matrix3 R = turn_about_up(closed->yaw_rad);
  double residual_sigmas_sq = 0.0;  // sum over samples and axes
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const Vector3 residual_m = local_m[i] - closed->point(other_m[i]);
    const Matrix3 S = covariance_local[i] + R * covariance_other[i] * R.transpose();
    residual_sigmas_sq += residual_m.dot(S.llt().solve(residual_m));
  }
  if (std::sqrt(residual_sigmas_sq / (3.0 * static_cast<double>(weights.size()))) > config_.residual_sigma_max)
    return std::nullopt;

  std::vector<AlignmentPair> pairs;
  append_pairs(own, other, closed->yaw_rad, pairs);
  RelativeAlignment fit(fit_of(config_), drift_config_);
  for (const AlignmentPair& pair : pairs) fit.push(pair);
  const auto& found = fit.fit(anchor, {});
  if (!found) return std::nullopt;
  return Match{own, other, *found, t_s.back() - t_s.front(), bends, {}};
}

}  // namespace swiftlet
