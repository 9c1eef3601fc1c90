// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/detection/hypothesis.hpp"
#include "core/detection/sweep_returns.hpp"
#include "swiftlet/core/detection/track_before_detect_config.hpp"

namespace swiftlet {

/// Dropped targets that may reappear. A new hypothesis within the reach of a former target continues its state, and its
/// identity once it has become a target.
class FormerTargets {
 public:
  explicit FormerTargets(const TrackBeforeDetectConfig& config);

  void predict(TimeNs t);
  /// Associates a new hypothesis with a former target, dropped or without returns in this sweep. The density of each at
  /// the measurement follows from its existence and predicted position. The densest one is accepted if it exceeds half
  /// of the sum of all and of new targets. Within the gate, the new hypothesis continues its state.
  /// @return density [1/m^3] of all former targets at the measurement
  double remember(std::span<const Hypothesis> hypotheses, const TargetMeasurement& measurement,
                  Hypothesis& new_hypothesis) const;
  /// A new hypothesis that has become a target takes the identity of its former target, unless the former
  /// target has had returns since.
  void inherit(std::span<Hypothesis> hypotheses);
  /// Remembers a dropped target.
  void add(const Hypothesis& dropped);
  /// Drops former targets whose position has become too uncertain.
  void forget();

 private:
  ExpectedTarget target_;
  std::size_t max_hidden_;
  std::vector<Hypothesis> hidden_;
};

}  // namespace swiftlet
