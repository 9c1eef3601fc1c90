// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// Are two targets parts of one large body? Between two bodies there is air, so hardly anything is returned from
/// there. One body returns beams from its middle as well. Bayes' rule for each pair of targets near each other: every
/// return counts, by the third of the way between both that it lies in.
class BodyParts {
 public:
  static constexpr double kMiddleOfOne =
      0.17;  ///< share of its returns that one body has in the middle third: 1/6 of a bar
  static constexpr double kMiddleOfTwo = 0.02;   ///< the same of two bodies: strays and noise
  static constexpr double kDecided = 3.0;        ///< log odds at which both are taken for one
  static constexpr double kSurest = 6.0;         ///< so it is never too sure to learn better
  static constexpr std::size_t kMostPairs = 64;  ///< that are remembered; others are not asked about

  BodyParts() { pairs_.reserve(kMostPairs); }

  /// One sweep begins: pairs that were not weighed in a while are forgotten.
  void begin_sweep();
  /// One sweep of a pair, in any order of both.
  /// @param a_local_m, b_local_m  returns of the one and of the other [m], local frame; each at least one
  /// @return whether both are one
  bool weigh(std::uint32_t id_a, std::span<const Vector3> a_local_m, std::uint32_t id_b,
             std::span<const Vector3> b_local_m);
  /// All pairs of one that is no more, or is another one now.
  void forget(std::uint32_t id);
  /// Log odds of one body against two; 0 of a pair that nothing is known of.
  double log_odds(std::uint32_t id_a, std::uint32_t id_b) const;

 private:
  struct Pair {
    std::uint32_t low = 0, high = 0;
    double log_odds = 0.0;
    int silent_sweeps = 0;

    bool is_of(std::uint32_t a, std::uint32_t b) const { return low == std::min(a, b) && high == std::max(a, b); }
  };

  std::vector<Pair> pairs_;
};

}  // namespace swiftlet
