// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Decides whether two targets are parts of one large body. The space between two bodies is air and returns hardly any
/// beams; one body also returns beams from its middle. Bayes' rule for each pair of targets near each other: every
/// return counts by the third of the segment between both in which it lies.
class BodyParts {
 public:
  static constexpr double kMiddleOfOne =
      0.17;  ///< share of its returns that one body has in the middle third: 1/6 of a bar
  static constexpr double kMiddleOfTwo = 0.02;  ///< same share for two bodies: stray returns and noise
  static constexpr double kDecided = 3.0;       ///< log odds at which the pair is merged
  static constexpr double kSurest = 6.0;  ///< limit of the log odds, so that later evidence can reverse the decision
  static constexpr std::size_t kMostPairs = 64;  ///< capacity; further pairs are not tested

  BodyParts() { pairs_.reserve(kMostPairs); }

  /// Begins a sweep: pairs without an update for a while are dropped.
  void begin_sweep();
  /// Updates a pair by one sweep; the order of the two does not matter.
  /// @param a_local_m, b_local_m  returns of the one and of the other [m], local frame; each at least one
  /// @return whether the pair is one body
  bool weigh(std::uint32_t id_a, std::span<const Vector3> a_local_m, std::uint32_t id_b,
             std::span<const Vector3> b_local_m);
  /// Drops all pairs of a target that is deleted or has changed identity.
  void forget(std::uint32_t id);
  /// Log odds of one body against two; 0 for an unknown pair.
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
