// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/former_targets.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace swiftlet {
namespace {

using Limits = TrackBeforeDetectLimits;

/// [1/m^3] Density of targets seen for the first time. Larger values give reappearing targets a new identity more
/// often.
constexpr double kNew_per_m3 = 2e-6;
/// [m] Largest standard deviation of the position, on any axis, at which a lost target is remembered, so that it keeps
/// its identity when it reappears. Larger values remember it longer.
constexpr double kSigmaHidden_m = 20.0;

}  // namespace

FormerTargets::FormerTargets(const TrackBeforeDetectConfig& config)
    : target_(config.target), max_hidden_(static_cast<std::size_t>(config.max_hypotheses)) {
  hidden_.reserve(max_hidden_);
}

void FormerTargets::predict(TimeNs t) {
  for (Hypothesis& h : hidden_) h.predict(t, target_);
}

double FormerTargets::remember(std::span<const Hypothesis> hypotheses, const TargetMeasurement& m,
                               Hypothesis& new_hypothesis) const {
  /// Match of one former target with the measurement.
  struct Match {
    const Hypothesis* former = nullptr;
    Vector3 innovation_m;
    Matrix3 S;
    double distance_sq = 0.0, density_per_m3 = 0.0;
  };
  double sum_per_m3 = 0.0;
  Match likeliest;
  const auto weigh = [&](const Hypothesis& h) {
    if (!h.was_target || h.num_returns > 0) return;
    const Eigen::Matrix<double, 3, 6> H = position_at(to_seconds(m.t - h.t));
    Match match{&h, m.p_local_m - H * h.mean, H * h.covariance * H.transpose() + m.covariance};
    match.distance_sq = match.innovation_m.dot(match.S.llt().solve(match.innovation_m));
    match.density_per_m3 = std::max(h.existence, Limits::kSilentTarget) * normal_density(match.distance_sq, match.S);
    sum_per_m3 += match.density_per_m3;
    if (match.density_per_m3 > likeliest.density_per_m3) likeliest = match;
  };
  for (const Hypothesis& h : hypotheses) weigh(h);
  for (const Hypothesis& h : hidden_) weigh(h);
  if (!(likeliest.density_per_m3 >= 0.5 * (sum_per_m3 + kNew_per_m3))) return sum_per_m3;
  if (likeliest.former == nullptr) return sum_per_m3;
  const Hypothesis& h = *likeliest.former;
  new_hypothesis.former_identity = h.identity;
  new_hypothesis.rate = h.rate;
  new_hypothesis.small = h.small;
  new_hypothesis.size_m = h.size_m;
  if (!(likeliest.distance_sq < Limits::kGate)) return sum_per_m3;
  Matrix6 F = Matrix6::Identity();
  F.topRightCorner<3, 3>() = to_seconds(m.t - h.t) * Matrix3::Identity();
  const Matrix6 P = F * h.covariance * F.transpose();
  const Eigen::Matrix<double, 6, 3> K = P.leftCols<3>() * likeliest.S.inverse();
  new_hypothesis.mean = F * h.mean + K * likeliest.innovation_m;
  new_hypothesis.covariance = P - K * likeliest.S * K.transpose();
  return sum_per_m3;
}

void FormerTargets::inherit(std::span<Hypothesis> hypotheses) {
  for (Hypothesis& successor : hypotheses) {
    if (successor.existence < Limits::kTarget) continue;
    successor.was_target = true;
    if (successor.former_identity == 0) continue;
    const auto is_former = [&](const Hypothesis& h) { return h.identity == successor.former_identity; };
    const auto hidden = std::find_if(hidden_.begin(), hidden_.end(), is_former);
    const auto missed = std::find_if(hypotheses.begin(), hypotheses.end(), is_former);
    const bool is_missed = missed != hypotheses.end() && missed->seen < successor.begun;
    const std::uint32_t identity =
        hidden != hidden_.end() || is_missed ? successor.former_identity : successor.identity;
    if (hidden != hidden_.end()) hidden_.erase(hidden);
    if (is_missed) {
      missed->existence = 0.0;
      missed->was_target = false;
    }
    for (Hypothesis& h : hypotheses) {
      if (&h == &successor || h.former_identity == identity) h.former_identity = 0;
    }
    successor.identity = identity;
  }
}

void FormerTargets::add(const Hypothesis& dropped) {
  if (hidden_.size() == max_hidden_) return;
  hidden_.push_back(dropped);
  hidden_.back().num_returns = 0;
}

void FormerTargets::forget() {
  std::erase_if(hidden_, [](const Hypothesis& h) {
    return !(h.position_covariance().diagonal().maxCoeff() <= kSigmaHidden_m * kSigmaHidden_m);
  });
}

}  // namespace swiftlet
