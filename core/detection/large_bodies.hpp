// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/detection/body_parts.hpp"
#include "core/detection/hypothesis.hpp"
#include "core/detection/sweep_returns.hpp"

namespace swiftlet {

/// Merges hypotheses of parts of one large body, each of which begins its own, when the returns between them indicate a
/// single body. Splits a body when the air between its halves indicates two.
class LargeBodies {
 public:
  explicit LargeBodies(const ExpectedTarget& target) : body_m_(target.body_m) {}

  /// When two hypotheses are merged, the older one remains; the existence of the other becomes 0.
  /// @param hypotheses  corrected by this sweep, the likeliest first
  void join_parts(const LocalCloud& cloud, std::span<Hypothesis> hypotheses, SweepReturns& returns);
  /// Largest size [m] of a merged body.
  double most_size_m() const { return TrackBeforeDetectLimits::kMaxSize * body_m_; }

 private:
  bool are_neighbors(std::span<const Hypothesis> hypotheses, std::size_t i, std::size_t j) const;
  void split(Hypothesis& hypothesis, std::size_t k, const SweepReturns& returns);
  void join(const LocalCloud& cloud, std::span<Hypothesis> hypotheses, std::size_t kept, std::size_t dropped,
            SweepReturns& returns);

  double body_m_;
  BodyParts parts_;
  std::vector<Vector3> part_a_m_, part_b_m_;
};

}  // namespace swiftlet
