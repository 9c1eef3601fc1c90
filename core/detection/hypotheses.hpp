// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/detection/empty_directions.hpp"
#include "core/detection/former_targets.hpp"
#include "core/detection/hypothesis.hpp"
#include "core/detection/large_bodies.hpp"
#include "core/detection/learned_air.hpp"
#include "core/detection/sweep_returns.hpp"
#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/base/detection.hpp"
#include "swiftlet/core/base/track.hpp"
#include "swiftlet/core/detection/track_before_detect_config.hpp"

namespace swiftlet {

/// Track before detect: a bank of Bernoulli hypotheses, each tracked from its first return on. All sweeps together
/// decide about existence. A return counts by its likelihood against that of clutter at its position; beams that should
/// have hit the target and returned nothing count against it. A target that is hidden, or out of the field of view, is
/// dropped when its position has become too uncertain. A new hypothesis within its reach continues its identity.
/// Processes one sweep at a time, without a clock. Time and memory are bounded.
class Hypotheses {
 public:
  explicit Hypotheses(const TrackBeforeDetectConfig& config);

  /// Processes one sweep: updates the hypotheses, then the background, then the free air.
  void take(const LocalCloud& cloud);

  /// All hypotheses, the likeliest first.
  std::span<const Hypothesis> all() const { return hypotheses_; }
  /// Appends the hypotheses above the reporting threshold; detections and tracks in the same order.
  void append_reported(std::vector<Detection>& detections) const;
  void append_reported(std::vector<Track>& tracks) const;
  void append_counters(std::vector<Counter>& counters) const;

 private:
  TimeNs middle() const { return returns_.beams().middle(); }
  void predict();
  void correct(const LocalCloud& cloud);
  void weigh_size(Hypothesis& hypothesis, const BeamExposure& exposure, double hidden, int num_returns);
  bool correct_by(Hypothesis& hypothesis, const TargetMeasurement& measurement, const BeamExposure& exposure);
  void miss(Hypothesis& hypothesis, const BeamExposure& exposure);
  void begin(const LocalCloud& cloud);
  Hypothesis newborn(const TargetMeasurement& measurement);
  void merge();
  void forget();
  void queue_for_background(std::span<const std::uint32_t> candidates, std::uint32_t hypothesis);
  double clutter_density_per_m3(const TargetMeasurement& measurement, double beams_per_sr) const;
  BeamExposure exposure_of(const Hypothesis& hypothesis) const;
  bool is_reported(const Hypothesis& hypothesis) const { return hypothesis.confidence() >= config_.reported_existence; }

  TrackBeforeDetectConfig config_;
  EmptyDirections empty_;
  SweepReturns returns_;
  LearnedAir air_;
  LargeBodies bodies_;
  FormerTargets former_;
  std::vector<Hypothesis> hypotheses_, born_;
  double small_log_odds_ = 0.0;  // prior log odds of smallness of a new hypothesis
  std::uint32_t next_id_ = 1;
  std::uint64_t num_born_ = 0, num_dropped_ = 0;
  std::vector<BeamExposure> exposures_;  // in this sweep, by hypothesis
};

}  // namespace swiftlet
