// SPDX-License-Identifier: BSD-3-Clause
#include "core/shared_tracks/frame_link.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

constexpr int kMaxDisagreements = 3;
constexpr double kDisagreement_sigma_sq = 30.0;  // chance level 1 in 200 000, with four degrees of freedom
constexpr int kLeastPairs = 8;                   // least pairs of a fit, spaced so that their errors are independent
constexpr int kCompareEvery = 2;                 // instants between comparisons of paths, once the filter runs

Matrix3 turn_about_up(double yaw_rad) {
  const double s = elementary::sin(yaw_rad), c = elementary::cos(yaw_rad);
  return (Matrix3() << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0).finished();
}

/// z x v: derivative of v with respect to a turn about the vertical.
Vector3 up_cross(const Vector3& v) { return {-v.y(), v.x(), 0.0}; }

Flown sum_of(const Flown& a, const Flown& b) {
  return {a.path_m + b.path_m, a.turn_rad + b.turn_rad, a.time_s + b.time_s};
}

/// RMS distance in the plane from the best-fitting motion of constant velocity.
double bend_m(std::span<const Vector3> p_m, std::span<const double> t_s) {
  const auto n = static_cast<double>(p_m.size());
  Vector3 mean_m = Vector3::Zero();
  double mean_s = 0.0;
  for (std::size_t i = 0; i < p_m.size(); ++i) {
    mean_m += p_m[i] / n;
    mean_s += t_s[i] / n;
  }
  Vector3 by_time = Vector3::Zero();
  double time_sq = 0.0;
  for (std::size_t i = 0; i < p_m.size(); ++i) {
    by_time += (t_s[i] - mean_s) * (p_m[i] - mean_m);
    time_sq += (t_s[i] - mean_s) * (t_s[i] - mean_s);
  }
  const Vector3 v_mps = time_sq > 0.0 ? Vector3(by_time / time_sq) : Vector3::Zero();
  double left_sq = 0.0;
  for (std::size_t i = 0; i < p_m.size(); ++i) {
    left_sq += (p_m[i] - mean_m - (t_s[i] - mean_s) * v_mps).head<2>().squaredNorm();
  }
  return std::sqrt(left_sq / n);
}

double spread_m(std::span<const Vector3> p_m) {
  Vector3 mean_m = Vector3::Zero();
  for (const Vector3& p : p_m) mean_m += p / static_cast<double>(p_m.size());
  double sum = 0.0;
  for (const Vector3& p : p_m) sum += (p - mean_m).head<2>().squaredNorm();
  return std::sqrt(sum / static_cast<double>(p_m.size()));
}

/// Squared Mahalanobis distance between two alignments about the same anchor.
double squared_sigmas_between(const FrameAlignment& a, const FrameAlignment& b) {
  Eigen::Matrix<double, 4, 1> difference;
  difference << a.anchor_local_m - b.anchor_local_m, std::remainder(a.yaw_rad - b.yaw_rad, 2.0 * kPi);
  const FrameAlignment::Covariance S = a.covariance + b.covariance;
  return difference.dot(S.ldlt().solve(difference));
}

RelativeAlignmentConfig fit_of(const FrameLinkConfig& config) {
  RelativeAlignmentConfig fit;
  fit.window_size = 1000;
  fit.window_step_m = 0.0;  // several objects are measured at one instant, and observers may hover
  fit.min_pairs = kLeastPairs;
  fit.residual_sigma_max = config.residual_sigma_max;
  fit.min_spread_m = config.min_spread_m;
  fit.heading_sigma_max_deg = config.heading_sigma_max_deg;
  return fit;
}

}  // namespace

void FrameLinkConfig::visit(ConfigVisitor& v) {
  v.field("min_spread_m", min_spread_m, "[m] least RMS distance of a path from its mean, in the plane",
          Range::positive());
  v.field("gate_sigma", gate_sigma, "[-] largest distance between tracks of one body, in standard deviations",
          Range::positive());
  v.field("margin", margin, "[-] twice the log-likelihood ratio by which a pair must exceed the next alternative",
          Range::non_negative());
  v.field("position_sigma_max_m", position_sigma_max_m,
          "[m] standard deviation of the position above which an alignment is lost", Range::positive());
  v.field("heading_sigma_max_deg", heading_sigma_max_deg,
          "[deg] standard deviation of the heading above which an alignment is lost", Range::positive());
}

FrameLink::FrameLink(const FrameLinkConfig& config, const OdometryDriftConfig& drift)
    : config_(config), drift_config_(drift), drift_(drift) {}

void FrameLink::clear() {
  started_ = false;
  alignment_.reset();
  last_ = measured_ = -1;
  num_disagreements_ = 0;
}

void FrameLink::update(const ObserverHistory& own, const ObserverHistory& other) {
  const TimeNs t = std::min(own.until(), other.until());
  if (t >= 0 && (last_ < 0 || t - last_ >= from_seconds(config_.interval_s))) compare(own, other, t);
  update_alignment(own, other);
}

void FrameLink::compare(const ObserverHistory& own, const ObserverHistory& other, TimeNs t) {
  const auto own_self = own.self().at(t, config_.gap_max_s), other_self = other.self().at(t, config_.gap_max_s);
  if (!own_self || !other_self) return;
  last_ = t;
  list_paths(own, other);
  if (started_) {
    state_ = drifted(state_, *own_self, *other_self);
    measure(t);
  }
  if (started_ && (t / from_seconds(config_.interval_s)) % kCompareEvery != 0) return;
  OtherMotion anchor;
  anchor.t = anchor.stamp = t;
  anchor.p_other_local_m = other_self->p_local_m;
  anchor.flown = sum_of(own_self->flown, other_self->flown);
  const auto found = found_by_paths(anchor);
  if (!found) return;
  if (started_) {
    const FrameAlignment now{state_.anchor_other_m, state_.x.head<3>(), state_.x(3), state_.P};
    num_disagreements_ = squared_sigmas_between(now, *found) <= kDisagreement_sigma_sq ? 0 : num_disagreements_ + 1;
    if (num_disagreements_ < kMaxDisagreements) return;
    ++num_lost_;
  }
  started_ = true;
  state_.anchor_other_m = found->anchor_other_m;
  state_.x << found->anchor_local_m, found->yaw_rad;
  state_.P = found->covariance;
  state_.own_flown = own_self->flown;
  state_.other_flown = other_self->flown;
  measured_ = t;
  num_disagreements_ = 0;
  ++num_starts_;
}

void FrameLink::list_paths(const ObserverHistory& own, const ObserverHistory& other) {
  const auto list = [](const ObserverHistory& history, std::vector<const SampledPath*>& paths) {
    paths.assign(1, &history.self());
    for (const ObserverHistory::Seen& seen : history.seen()) paths.push_back(&seen.path);
  };
  list(own, own_paths_);
  list(other, other_paths_);
}

// ---- association of paths

std::optional<FrameAlignment> FrameLink::found_by_paths(const OtherMotion& anchor) const {
  std::vector<Match> matches;
  for (std::size_t a = 0; a < own_paths_.size(); ++a) {
    for (std::size_t b = a == 0 ? 1 : 0; b < other_paths_.size(); ++b) {
      if (auto found = match(a, b, anchor)) matches.push_back(std::move(*found));
    }
  }
  if (matches.empty()) return std::nullopt;
  for (Match& each : matches) find_support(each, anchor);
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
  RelativeAlignment together(fit_of(config_), drift_config_);
  for (const AlignmentPair& pair : pairs) together.push(pair);
  return together.fit(anchor, {});
}

/// Collects pairs of paths that agree with the match; each path counts once.
void FrameLink::find_support(Match& match, const OtherMotion& anchor) const {
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

/// Does the alignment map these two paths, straight or not, onto each other for long enough to exclude chance?
bool FrameLink::supports(std::size_t own, std::size_t other, const FrameAlignment& alignment,
                         const OtherMotion& anchor) const {
  const Matrix3 R = turn_about_up(alignment.yaw_rad);
  double squared = 0.0, variance_m2 = 0.0;
  int count = 0;
  TimeNs first = 0, last = 0;
  for (const PathSample& s : other_paths_[other]->samples()) {
    const auto seen = own_paths_[own]->at(s.t, config_.gap_max_s);
    if (!seen) continue;
    const Flown since = anchor.flown - sum_of(seen->flown, s.flown);
    const double more = config_.sigma_common_m * config_.sigma_common_m + drift_.position_variance_m2(since);
    Eigen::Matrix<double, 3, 4> J;
    J << Matrix3::Identity(), up_cross(R * (s.p_local_m - alignment.anchor_other_m));
    const Matrix3 S = seen->covariance + R * s.covariance * R.transpose() + more * Matrix3::Identity() +
                      J * alignment.covariance * J.transpose();
    const Vector3 left_m = seen->p_local_m - alignment.point(s.p_local_m);
    squared += left_m.dot(S.llt().solve(left_m));
    variance_m2 += S.trace() / 3.0;
    if (count++ == 0) first = s.t;
    last = s.t;
  }
  return count >= kLeastPairs && last - first >= from_seconds(config_.support_s) &&
         squared <= 3.0 * count * config_.residual_sigma_max * config_.residual_sigma_max &&
         variance_m2 <= count * config_.support_sigma_m * config_.support_sigma_m;
}

/// Appends pairs at least interval_s apart, from the newest back, so that their errors are independent.
void FrameLink::append_pairs(std::size_t own, std::size_t other, double yaw_rad,
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

std::optional<FrameLink::Match> FrameLink::match(std::size_t own, std::size_t other, const OtherMotion& anchor) const {
  std::vector<Vector3> local_m, other_m;
  std::vector<double> weights, t_s;
  std::vector<Matrix3> covariance_local, covariance_other;
  for (const PathSample& s : other_paths_[other]->samples()) {
    const auto seen = own_paths_[own]->at(s.t, config_.gap_max_s);
    if (!seen) continue;
    const Flown since = anchor.flown - sum_of(seen->flown, s.flown);
    const double more = config_.sigma_common_m * config_.sigma_common_m + drift_.position_variance_m2(since);
    local_m.push_back(seen->p_local_m);
    other_m.push_back(s.p_local_m);
    t_s.push_back(to_seconds(s.t - anchor.t));
    covariance_local.push_back(seen->covariance + more * Matrix3::Identity());
    covariance_other.push_back(s.covariance);
    weights.push_back(3.0 / (covariance_local.back().trace() + s.covariance.trace()));
  }
  if (static_cast<int>(weights.size()) < config_.min_samples) return std::nullopt;
  const double bent_m = bend_m(local_m, t_s);
  if (spread_m(local_m) < config_.min_spread_m || bent_m < config_.min_bend_m) return std::nullopt;
  double variance_m2 = 0.0;  // mean variance by axis
  for (const double weight : weights) variance_m2 += 1.0 / weight / static_cast<double>(weights.size());
  const double bends = bent_m / std::sqrt(variance_m2);
  if (bends < config_.bend_sigmas) return std::nullopt;
  const auto closed = align_in_closed_form(local_m, other_m, weights);
  if (!closed) return std::nullopt;
  const Matrix3 R = turn_about_up(closed->yaw_rad);
  double squared = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const Vector3 left_m = local_m[i] - closed->point(other_m[i]);
    const Matrix3 S = covariance_local[i] + R * covariance_other[i] * R.transpose();
    squared += left_m.dot(S.llt().solve(left_m));
  }
  if (std::sqrt(squared / (3.0 * static_cast<double>(weights.size()))) > config_.residual_sigma_max)
    return std::nullopt;

  std::vector<AlignmentPair> pairs;
  append_pairs(own, other, closed->yaw_rad, pairs);
  RelativeAlignment fit(fit_of(config_), drift_config_);
  for (const AlignmentPair& pair : pairs) fit.push(pair);
  const auto& found = fit.fit(anchor, {});
  if (!found) return std::nullopt;
  return Match{own, other, *found, t_s.back() - t_s.front(), bends, {}};
}

// ---- filter of the alignment

/// A turn of an odometry's frame rotates later motion about the observer's position at that time: for the other
/// observer half-way along its step, for the own one about itself.
FrameLink::State FrameLink::drifted(const State& before, const PathSample& own, const PathSample& other) const {
  State now = before;
  const Flown by_own = own.flown - before.own_flown, by_other = other.flown - before.other_flown;
  const Vector3 step_m = turn_about_up(before.x(3)) * (other.p_local_m - before.anchor_other_m);
  Vector4 of_other, of_own;
  of_other << up_cross(-0.5 * step_m), 1.0;
  of_own << up_cross(before.x.head<3>() - own.p_local_m), 1.0;
  now.P += drift_.yaw_variance_rad2(by_other) * (of_other * of_other.transpose());
  now.P += drift_.yaw_variance_rad2(by_own) * (of_own * of_own.transpose());
  now.P.diagonal().head<3>().array() += drift_.position_variance_m2(by_own) + drift_.position_variance_m2(by_other);
  // The anchor moves with the other observer.
  now.x.head<3>() += step_m;
  Matrix4 A = Matrix4::Identity();
  A.topRightCorner<3, 1>() = up_cross(step_m);
  const Matrix4 P = A * now.P * A.transpose();
  now.P = 0.5 * (P + P.transpose());
  now.anchor_other_m = other.p_local_m;
  now.own_flown = own.flown;
  now.other_flown = other.flown;
  return now;
}

void FrameLink::measure(TimeNs t) {
  Vector4& x = state_.x;
  Matrix4& P = state_.P;
  struct Seen {
    bool there = false;
    Vector3 p_m, lever_m = Vector3::Zero();
    Matrix3 covariance;
  };
  const Matrix3 R = turn_about_up(x(3));
  std::vector<Seen> own(own_paths_.size()), other(other_paths_.size());
  for (std::size_t a = 0; a < own.size(); ++a) {
    if (const auto s = own_paths_[a]->at(t, config_.gap_max_s))
      own[a] = {true, s->p_local_m, Vector3::Zero(), s->covariance};
  }
  for (std::size_t b = 0; b < other.size(); ++b) {
    const auto s = other_paths_[b]->at(t, config_.gap_max_s);
    if (!s) continue;
    const Vector3 lever_m = R * (s->p_local_m - state_.anchor_other_m);
    other[b] = {true, x.head<3>() + lever_m, lever_m, R * s->covariance * R.transpose()};
  }
  const double common_sq = config_.sigma_common_m * config_.sigma_common_m;
  const auto jacobian = [](const Seen& s) {
    Eigen::Matrix<double, 3, 4> H;
    H << Matrix3::Identity(), up_cross(s.lever_m);
    return H;
  };
  // Negative log-likelihood, times two, that two tracks are one target; infinite beyond the gate.
  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::vector<double> unlikely(own.size() * other.size(), kNever);
  for (std::size_t a = 0; a < own.size(); ++a) {
    for (std::size_t b = a == 0 ? 1 : 0; b < other.size(); ++b) {
      if (!own[a].there || !other[b].there) continue;
      const Eigen::Matrix<double, 3, 4> H = jacobian(other[b]);
      const Matrix3 S =
          own[a].covariance + other[b].covariance + H * P * H.transpose() + common_sq * Matrix3::Identity();
      const Vector3 off_m = own[a].p_m - other[b].p_m;
      const double squared = off_m.dot(S.llt().solve(off_m));
      if (squared > config_.gate_sigma * config_.gate_sigma) continue;
      unlikely[a * other.size() + b] = squared + elementary::log(S.determinant());
    }
  }
  std::vector<std::pair<std::size_t, std::size_t>> sure;
  for (std::size_t a = 0; a < own.size(); ++a) {
    for (std::size_t b = 0; b < other.size(); ++b) {
      const double here = unlikely[a * other.size() + b];
      if (here == kNever) continue;
      double next = kNever;
      for (std::size_t k = 0; k < other.size(); ++k) {
        if (k != b) next = std::min(next, unlikely[a * other.size() + k]);
      }
      for (std::size_t k = 0; k < own.size(); ++k) {
        if (k != a) next = std::min(next, unlikely[k * other.size() + b]);
      }
      if (here + config_.margin <= next) sure.emplace_back(a, b);
    }
  }
  const Vector4 before = x;
  for (const auto& [a, b] : sure) {
    const Eigen::Matrix<double, 3, 4> H = jacobian(other[b]);
    const Matrix3 noise = own[a].covariance + other[b].covariance + common_sq * Matrix3::Identity();
    const Vector3 innovation_m = own[a].p_m - (other[b].p_m + H * (x - before));
    const Eigen::Matrix<double, 4, 3> PHt = P * H.transpose();
    const Matrix3 S = H * PHt + noise;
    const Eigen::Matrix<double, 4, 3> K = S.llt().solve(PHt.transpose()).transpose();
    x += K * innovation_m;
    const Matrix4 I_KH = Matrix4::Identity() - K * H;  // Joseph's form stays positive definite despite rounding
    const Matrix4 after = I_KH * P * I_KH.transpose() + K * noise * K.transpose();
    P = 0.5 * (after + after.transpose());
    measured_ = t;
  }
}

/// Publishes the present alignment, propagated by odometry since the newest common instant. Drops one that is too
/// uncertain.
void FrameLink::update_alignment(const ObserverHistory& own, const ObserverHistory& other) {
  alignment_.reset();
  if (!started_ || own.self().empty() || other.self().empty()) return;
  const State now = drifted(state_, own.self().newest(), other.self().newest());
  const Matrix3 place = now.P.topLeftCorner<3, 3>();
  const double greatest = Eigen::SelfAdjointEigenSolver<Matrix3>(place, Eigen::EigenvaluesOnly).eigenvalues()(2);
  const double heading_max_rad = config_.heading_sigma_max_deg * kRadPerDeg;
  if (!(greatest <= config_.position_sigma_max_m * config_.position_sigma_max_m) ||
      !(now.P(3, 3) <= heading_max_rad * heading_max_rad)) {
    started_ = false;
    ++num_lost_;
    return;
  }
  FrameAlignment alignment;
  alignment.anchor_other_m = now.anchor_other_m;
  alignment.anchor_local_m = now.x.head<3>();
  alignment.yaw_rad = std::remainder(now.x(3), 2.0 * kPi);
  alignment.covariance = now.P;
  alignment.covariance.diagonal().head<3>().array() += config_.sigma_common_m * config_.sigma_common_m;
  alignment_ = alignment;
}

MotionEstimate in_own_frame(const FrameAlignment& alignment, const MotionEstimate& in_other) {
  const Matrix3 R = turn_about_up(alignment.yaw_rad);
  const Vector3 lever_m = R * (in_other.p_m() - alignment.anchor_other_m), v_mps = R * in_other.v_mps();
  MotionEstimate out;
  out.mean << alignment.anchor_local_m + lever_m, v_mps;
  Matrix6 both = Matrix6::Zero();
  both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = R;
  Eigen::Matrix<double, 6, 4> J = Eigen::Matrix<double, 6, 4>::Zero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.col(3) << up_cross(lever_m), up_cross(v_mps);
  const Matrix6 C = both * in_other.covariance * both.transpose() + J * alignment.covariance * J.transpose();
  out.covariance = 0.5 * (C + C.transpose());
  return out;
}

}  // namespace swiftlet
