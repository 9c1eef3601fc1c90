// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/large_bodies.hpp"

#include <algorithm>

namespace swiftlet {
namespace {

using Limits = TrackBeforeDetectLimits;

}  // namespace

void LargeBodies::join_parts(const LocalCloud& cloud, std::span<Hypothesis> hypotheses, SweepReturns& returns) {
  parts_.begin_sweep();
  for (std::size_t k = 0; k < hypotheses.size(); ++k) split(hypotheses[k], k, returns);
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    for (std::size_t j = i + 1; j < hypotheses.size(); ++j) {
      const Hypothesis &a = hypotheses[i], &b = hypotheses[j];
      if (a.existence < Limits::kTarget) break;
      if (!are_neighbors(hypotheses, i, j)) continue;
      returns.positions_of(i, part_a_m_);
      returns.positions_of(j, part_b_m_);
      const bool is_one = parts_.weigh(a.id, part_a_m_, b.id, part_b_m_);
      const bool is_inside = (a.p_local_m() - b.p_local_m()).norm() < 0.5 * std::max(a.size_m, b.size_m);
      if (!is_one && !is_inside) continue;
      const bool a_is_older = a.begun != b.begun ? a.begun < b.begun : a.id < b.id;
      join(cloud, hypotheses, a_is_older ? i : j, a_is_older ? j : i, returns);
    }
  }
}

// True for two targets seen in this sweep that may be one body: no other target is nearer to both.
bool LargeBodies::are_neighbors(std::span<const Hypothesis> hypotheses, std::size_t i, std::size_t j) const {
  const auto apart_m = [&](std::size_t k, std::size_t l) {
    return (hypotheses[k].p_local_m() - hypotheses[l].p_local_m()).norm();
  };
  const auto is_seen = [&](std::size_t k) {
    return hypotheses[k].existence >= Limits::kTarget && hypotheses[k].num_returns > 0;
  };
  if (!is_seen(i) || !is_seen(j) || !(apart_m(i, j) < body_m_)) return false;
  for (std::size_t k = 0; k < hypotheses.size(); ++k) {
    if (k == i || k == j || !is_seen(k)) continue;
    if (apart_m(k, i) < apart_m(i, j) && apart_m(k, j) < apart_m(i, j)) return false;
  }
  return true;
}

// Splits a large body when the air between its halves indicates two. The hypothesis keeps one half with the size of a
// usual target, so that the returns of the other half begin a new hypothesis.
void LargeBodies::split(Hypothesis& h, std::size_t k, const SweepReturns& returns) {
  if (!(h.size_m > 0.0) || returns.of(k).size() < Limits::kMinReturnsToSplit) return;
  returns.positions_of(k, part_a_m_);
  Vector3 mean_m = Vector3::Zero();
  for (const Vector3& p_m : part_a_m_) mean_m += p_m / static_cast<double>(part_a_m_.size());
  const auto is_nearer = [&](const Vector3& a_m, const Vector3& b_m) {
    return (a_m - mean_m).squaredNorm() < (b_m - mean_m).squaredNorm();
  };
  const Vector3 axis_m = *std::max_element(part_a_m_.begin(), part_a_m_.end(), is_nearer) - mean_m;
  part_b_m_.clear();
  for (const Vector3& p_m : part_a_m_) {
    if ((p_m - mean_m).dot(axis_m) > 0.0) part_b_m_.push_back(p_m);
  }
  std::erase_if(part_a_m_, [&](const Vector3& p_m) { return (p_m - mean_m).dot(axis_m) > 0.0; });
  if (part_a_m_.empty() || part_b_m_.empty()) return;
  parts_.weigh(h.id, part_a_m_, h.id, part_b_m_);
  if (parts_.log_odds(h.id, h.id) > -kMaxLogOdds) return;
  h.size_m = 0.0;
  parts_.forget(h.id);
}

// Keeps the older hypothesis, with the mean of both states and the spread between them.
void LargeBodies::join(const LocalCloud& cloud, std::span<Hypothesis> hypotheses, std::size_t kept, std::size_t dropped,
                       SweepReturns& returns) {
  Hypothesis &h = hypotheses[kept], &other = hypotheses[dropped];
  const Vector6 difference = other.mean - h.mean;
  h.size_m = std::min(std::max({h.size_m, other.size_m, 2.0 * difference.head<3>().norm()}), most_size_m());
  h.mean += 0.5 * difference;
  h.covariance = 0.5 * (h.covariance + other.covariance) + 0.25 * difference * difference.transpose();
  h.existence = std::max(h.existence, other.existence);
  other.existence = 0.0;
  other.was_target = false;
  parts_.forget(other.id);
  parts_.forget(h.id);
  returns.add_to(kept, dropped);
  returns.measure(cloud, returns.of(kept), h.size_m).keep_in(h);
}

}  // namespace swiftlet
