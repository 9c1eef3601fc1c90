// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/detection/body_parts.hpp"
#include "core/detection/hypothesis.hpp"
#include "core/detection/sweep_returns.hpp"

namespace swiftlet {

/// Each part of a large body begins its own hypothesis. Joins those whose returns show a single body, and splits a body
/// when the air between its halves shows two.
class LargeBodies {
 public:
  explicit LargeBodies(const ExpectedTarget& target) : body_m_(target.body_m) {}

  /// @param hypotheses  corrected by this sweep, the likeliest first. Of two joined ones the older is kept; the other
  ///                    one's existence becomes 0
  void join_parts(const LocalCloud& cloud, std::span<Hypothesis> hypotheses, SweepReturns& returns);
  double most_size_m() const { return TrackBeforeDetectLimits::kMostSize * body_m_; }

 private:
  bool are_neighbors(std::span<const Hypothesis> hypotheses, std::size_t i, std::size_t j) const;
  void split(Hypothesis& hypothesis, std::size_t k, const SweepReturns& returns);
  void join(const LocalCloud& cloud, std::span<Hypothesis> hypotheses, std::size_t stays, std::size_t goes,
            SweepReturns& returns);

  double body_m_;
  BodyParts parts_;
  std::vector<Vector3> part_a_m_, part_b_m_;
};

}  // namespace swiftlet
