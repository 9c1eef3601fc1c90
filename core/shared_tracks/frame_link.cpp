// SPDX-License-Identifier: BSD-3-Clause
#include "core/shared_tracks/frame_link.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "core/shared_tracks/level_alignment.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [-] Comparisons in a row that contradict the filter until it is reset. Smaller values react to chance matches.
constexpr int kMaxDisagreements = 3;
constexpr int kCompareEvery = 2;  // instants between comparisons of paths, once the filter runs

}  // namespace

FrameLink::FrameLink(const FrameLinkConfig& config, const OdometryDriftConfig& drift)
    : config_(config), drift_(drift), paths_(config, drift) {}

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
  paths_.list(own, other);
  if (started_) {
    state_ = drifted(state_, *own_self, *other_self);
    measure(t);
  }
  if (started_ && (t / from_seconds(config_.interval_s)) % kCompareEvery != 0) return;
  OtherMotion anchor;
  anchor.t = anchor.stamp = t;
  anchor.p_other_local_m = other_self->p_local_m;
  anchor.flown = sum_of(own_self->flown, other_self->flown);
  const auto found = paths_.find(anchor);
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

Eigen::Matrix<double, 3, 4> FrameLink::Seen::jacobian() const {
  Eigen::Matrix<double, 3, 4> H;
  H << Matrix3::Identity(), up_cross(lever_local_m);
  return H;
}

/// Points of a list of paths at t.
std::vector<FrameLink::Seen> FrameLink::seen_at(TimeNs t, std::span<const SampledPath* const> paths) const {
  std::vector<Seen> seen(paths.size());
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (const auto s = paths[i]->at(t, config_.gap_max_s))
      seen[i] = {true, s->p_local_m, Vector3::Zero(), s->covariance};
  }
  return seen;
}

/// Index pairs of points that are unambiguously of one body.
std::vector<std::pair<std::size_t, std::size_t>> FrameLink::sure_pairs(std::span<const Seen> own,
                                                                       std::span<const Seen> other) const {
  // Negative log-likelihood, times two, that two tracks are one target; infinite beyond the gate.
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double common_sq = config_.sigma_common_m * config_.sigma_common_m;
  std::vector<double> unlikely(own.size() * other.size(), kNever);
  for (std::size_t a = 0; a < own.size(); ++a) {
    for (std::size_t b = a == 0 ? 1 : 0; b < other.size(); ++b) {
      if (!own[a].there || !other[b].there) continue;
      const Eigen::Matrix<double, 3, 4> H = other[b].jacobian();
      const Matrix3 S =
          own[a].covariance + other[b].covariance + H * state_.P * H.transpose() + common_sq * Matrix3::Identity();
      const Vector3 off_m = own[a].p_local_m - other[b].p_local_m;
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
  return sure;
}

void FrameLink::measure(TimeNs t) {
  Vector4& x = state_.x;
  Matrix4& P = state_.P;
  const Matrix3 R = turn_about_up(x(3));
  const std::vector<Seen> own = seen_at(t, paths_.own());
  std::vector<Seen> other = seen_at(t, paths_.other());
  for (Seen& s : other) {
    if (!s.there) continue;
    s.lever_local_m = R * (s.p_local_m - state_.anchor_other_m);
    s.p_local_m = x.head<3>() + s.lever_local_m;
    s.covariance = R * s.covariance * R.transpose();
  }
  const double common_sq = config_.sigma_common_m * config_.sigma_common_m;
  const Vector4 before = x;
  for (const auto& [a, b] : sure_pairs(own, other)) {
    const Eigen::Matrix<double, 3, 4> H = other[b].jacobian();
    const Matrix3 noise = own[a].covariance + other[b].covariance + common_sq * Matrix3::Identity();
    const Vector3 innovation_m = own[a].p_local_m - (other[b].p_local_m + H * (x - before));
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
