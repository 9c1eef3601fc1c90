// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/former_targets.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace swiftlet {
namespace {

using Limits = TrackBeforeDetectLimits;

}  // namespace

FormerTargets::FormerTargets(const TrackBeforeDetectConfig& config)
    : target_(config.target),
      sigma_hidden_m_(config.sigma_hidden_m),
      most_(static_cast<std::size_t>(config.max_hypotheses)) {
  hidden_.reserve(most_);
}

void FormerTargets::predict(TimeNs t) {
  for (Hypothesis& h : hidden_) h.predict(t, target_);
}

double FormerTargets::remember(std::span<const Hypothesis> hypotheses, const TargetMeasurement& m,
                               Hypothesis& new_hypothesis) const {
  /// Match of one former target with the measurement.
  struct Meeting {
    const Hypothesis* of = nullptr;
    Vector3 off_m;
    Matrix3 S;
    double squared = 0.0, here_per_m3 = 0.0;
  };
  double sum_per_m3 = 0.0;
  Meeting likeliest;
  const auto weigh = [&](const Hypothesis& h) {
    if (!h.was_target || h.num_returns > 0) return;
    const Eigen::Matrix<double, 3, 6> H = position_at(to_seconds(m.t - h.t));
    Meeting meeting{&h, m.p_local_m - H * h.mean, H * h.covariance * H.transpose() + m.covariance};
    meeting.squared = meeting.off_m.dot(meeting.S.llt().solve(meeting.off_m));
    meeting.here_per_m3 = std::max(h.existence, Limits::kSilentTarget) * normal_density(meeting.squared, meeting.S);
    sum_per_m3 += meeting.here_per_m3;
    if (meeting.here_per_m3 > likeliest.here_per_m3) likeliest = meeting;
  };
  for (const Hypothesis& h : hypotheses) weigh(h);
  for (const Hypothesis& h : hidden_) weigh(h);
  if (!(likeliest.here_per_m3 >= 0.5 * (sum_per_m3 + target_.strangers_per_m3))) return sum_per_m3;
  if (likeliest.of == nullptr) return sum_per_m3;
  const Hypothesis& h = *likeliest.of;
  new_hypothesis.former_identity = h.identity;
  new_hypothesis.rate = h.rate;
  new_hypothesis.small = h.small;
  new_hypothesis.size_m = h.size_m;
  if (!(likeliest.squared < Limits::kGate)) return sum_per_m3;
  Matrix6 F = Matrix6::Identity();
  F.topRightCorner<3, 3>() = to_seconds(m.t - h.t) * Matrix3::Identity();
  const Matrix6 P = F * h.covariance * F.transpose();
  const Eigen::Matrix<double, 6, 3> K = P.leftCols<3>() * likeliest.S.inverse();
  new_hypothesis.mean = F * h.mean + K * likeliest.off_m;
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
  if (hidden_.size() == most_) return;
  hidden_.push_back(dropped);
  hidden_.back().num_returns = 0;
}

void FormerTargets::forget() {
  std::erase_if(hidden_, [&](const Hypothesis& h) {
    return !(h.position_covariance().diagonal().maxCoeff() <= sigma_hidden_m_ * sigma_hidden_m_);
  });
}

}  // namespace swiftlet
