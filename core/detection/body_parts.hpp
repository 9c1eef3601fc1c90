// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Decides whether two targets close to each other are parts of one large body. One body also returns beams from its
/// middle, whereas the air between two bodies returns hardly any. Each return of the pair updates the odds of both
/// cases by Bayes' rule. Its evidence is whether it lies in the middle third of the segment between the two centers.
class BodyParts {
 public:
  /// [-] Share of the returns of one body in the middle third: 1/6 for a uniform bar whose halves are the two targets.
  /// Larger values need more returns between two targets to merge them.
  static constexpr double kMiddleOfOne = 0.17;
  /// [-] Share of the returns of two bodies in the middle third: stray returns and noise. Larger values need more
  /// returns there for a merge.
  static constexpr double kMiddleOfTwo = 0.02;
  /// [-] Log odds above which the pair is merged. Larger values need more sweeps for a merge.
  static constexpr double kDecided = 3.0;
  /// [-] Maximum number of pairs under test; further pairs are not merged.
  static constexpr std::size_t kMaxPairs = 64;

  BodyParts() { pairs_.reserve(kMaxPairs); }

  /// Begins a sweep: drops pairs that have not been updated for many sweeps.
  void begin_sweep();
  /// Updates the odds of a pair by the returns of one sweep. The order of the two targets does not matter.
  /// @param a_local_m, b_local_m  returns of the two targets in the local frame; neither may be empty
  /// @return true if the pair is one body
  bool weigh(std::uint32_t id_a, std::span<const Vector3> a_local_m, std::uint32_t id_b,
             std::span<const Vector3> b_local_m);
  /// Drops all pairs of a target that is deleted or has changed identity.
  void forget(std::uint32_t id);
  /// Log odds of one body against two; 0 for an unknown pair.
  double log_odds(std::uint32_t id_a, std::uint32_t id_b) const;

 private:
  struct Pair {
    std::uint32_t low = 0, high = 0;  // ids of the targets
    double log_odds = 0.0;
    int silent_sweeps = 0;  // sweeps since the last update

    bool is_of(std::uint32_t a, std::uint32_t b) const { return low == std::min(a, b) && high == std::max(a, b); }
  };

  std::vector<Pair> pairs_;
};

}  // namespace swiftlet
