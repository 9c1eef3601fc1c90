// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/interception/chase_team.hpp"
#include "core/interception/target_prediction.hpp"
#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// Selects the track to pursue: the configured vehicle, or the nearest one that is no teammate. Local frame.
class TargetSelection {
 public:
  /// @param named_id  track of the configured target; empty: any track but teammates
  TargetSelection(const InterceptConfig& config, std::optional<std::uint32_t> named_id);

  /// Selects the target's track in this tick and predicts it; null: none.
  /// @param chasing  the vehicle pursues its target: tracks far from the prediction are other objects
  const Track* select(const GuidanceInput& input, const ChaseTeam& team, bool chasing);
  void forget() { id_.reset(); }

  bool is_named() const { return named_id_.has_value(); }
  /// Track of the present or lost target; empty: no target so far.
  std::optional<std::uint32_t> id() const { return id_; }
  /// Prediction from the present time on; of a lost target from its last track on.
  const TargetPrediction& prediction() const { return prediction_; }
  /// Position of the target, by now.
  Vector3 expected_m(TimeNs now) const { return prediction_.at(to_seconds(now - selected_)).p_m; }
  /// Largest distance of the target from expected_m().
  double gate_m(TimeNs now) const;
  /// Time since the last measurement; empty: the track only continues by prediction.
  std::optional<double> unmeasured_s(TimeNs now) const;

 private:
  double cost_m(const Track& track, const GuidanceInput& input, const ChaseTeam& team, bool chasing) const;

  TargetPredictionConfig prediction_config_;
  std::optional<std::uint32_t> named_id_, id_;
  TargetPrediction prediction_;
  TimeNs selected_ = 0;             // time of the last selection of a track
  std::optional<TimeNs> measured_;  // time of the last measurement of the target
};

}  // namespace swiftlet
