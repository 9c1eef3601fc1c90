// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/target_selection.hpp"

#include <algorithm>
#include <limits>

namespace swiftlet {
namespace {

struct SelectionTuning {
  /// [s] Age above which a track counts as lost. Larger values pursue outdated predictions.
  double track_timeout_s = 1.0;
  /// [m/s] Growth rate of the association gate, from kSameTarget_m on, while the target has no track. Larger values
  /// accept other objects as the target.
  double gate_growth_mps = 3.0;
  /// [m] Additional cost of a target that another interceptor pursues as leader. Greater than any distance, so that
  /// targets without a leader come first.
  double led_cost_m = 1e6;
};
constexpr SelectionTuning kSelection;
/// [m] Cost of a track that must not be selected.
constexpr double kIneligible_m = std::numeric_limits<double>::infinity();

}  // namespace

TargetSelection::TargetSelection(const InterceptConfig& config, std::optional<std::uint32_t> named_id)
    : prediction_config_(config.prediction), named_id_(named_id) {}

const Track* TargetSelection::select(const GuidanceInput& input, const ChaseTeam& team, bool chasing) {
  const Track* best = nullptr;
  double least_m = kIneligible_m;
  for (const Track& track : input.tracks) {
    const double cost = cost_m(track, input, team, chasing);
    if (cost >= least_m) continue;
    least_m = cost;
    best = &track;
  }
  if (best == nullptr) return nullptr;
  const TimeNs now = input.observation.t;
  const auto modes = std::ranges::find_if(input.track_modes, [&](const TrackModes& m) { return m.id == best->id; });
  prediction_ = TargetPrediction(prediction_config_, *best, modes == input.track_modes.end() ? nullptr : &*modes, now);
  if (best->id != id_) measured_.reset();
  if (best->corrected) measured_ = best->t;
  id_ = best->id;
  selected_ = now;
  return best;
}

/// Cost by which tracks are compared: -1 for the present target, else the distance from the target's prediction, or
/// from the vehicle if there is no target so far. Targets of a leading teammate cost more; kIneligible_m: no target.
double TargetSelection::cost_m(const Track& track, const GuidanceInput& input, const ChaseTeam& team,
                               bool chasing) const {
  const TimeNs now = input.observation.t;
  if (to_seconds(now - track.t) > kSelection.track_timeout_s) return kIneligible_m;
  if (named_id_) return track.id == *named_id_ ? 0.0 : kIneligible_m;
  if (team.is_teammate(track.id)) return kIneligible_m;
  const bool is_free = !team.has_leader(track.position_m, now);
  const double led_m = is_free ? 0.0 : kSelection.led_cost_m;
  const double distance_m = (track.position_m - input.estimate.T_local_body.translation()).norm();
  if (!id_) return distance_m + led_m;
  const bool same = track.id == *id_;
  const double deviation_m = (track.position_m - expected_m(now)).norm();
  const bool is_other_object = chasing && !same && deviation_m > gate_m(now);
  if (!is_other_object) return (same ? -1.0 : deviation_m) + led_m;
  // A vehicle that yields its target to a leader may change to a target without a leader.
  return team.yields() && is_free ? distance_m : kIneligible_m;
}

double TargetSelection::gate_m(TimeNs now) const {
  return kSameTarget_m + kSelection.gate_growth_mps * to_seconds(now - selected_);
}

std::optional<double> TargetSelection::unmeasured_s(TimeNs now) const {
  return measured_ ? std::optional(to_seconds(now - *measured_)) : std::nullopt;
}

}  // namespace swiftlet
