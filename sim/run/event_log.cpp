// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/event_log.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace swiftlet::sim {
namespace {

// [ns] Time for which the run continues after the last mission has ended, so that recordings show the end.
constexpr TimeNs kAfterTheEnd = kNsPerSecond / 2;
// [ns] The same after a capture: longer, so that recordings show the interceptor's reaction.
constexpr TimeNs kAfterCapture = kNsPerSecond;

}  // namespace

EventLog::EventLog(std::vector<std::string> vehicle_names, std::vector<Perception> perception)
    : names_(std::move(vehicle_names)), perception_(std::move(perception)), ended_(names_.size(), false) {
  for (std::size_t i = 0; i < names_.size(); ++i) agents_.emplace_back(static_cast<VehicleId>(i));
}

void EventLog::collect(TimeNs now, const PhysicsWorld& physics, std::span<const Action* const> actions) {
  events_.clear();
  for (const Crash& crash : physics.crashes()) note_crash(crash);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const auto vehicle = static_cast<VehicleId>(i);
    const VehicleState& state = physics.state(vehicle);
    if (state.crashed) continue;  // estimates of a crashed vehicle's agent are ignored
    agents_[i].collect(now, *actions[i], state.p_world_m, events_);
    ended_[i] = ended_[i] || agents_[i].mission_is_over();
  }
  end_if_over(now + kAfterTheEnd);
}

void EventLog::note_captures(TimeNs now, const SeriesOf<CaptureRecord>& captures) {
  for (std::size_t k = 0; k < captures.size(); ++k) {
    const VehicleId interceptor = captures.about(k);
    const CaptureRecord& capture = captures.rows()[k];
    events_.push_back({capture.t, "capture", interceptor, names_[capture.target], capture.p_world_m,
                       fmt::format("{:.3f} m from the middle of the net", capture.miss_m)});
    const int wanted = perception_[interceptor].captures;
    if (wanted == 0 || capture.number < wanted) continue;
    ended_[interceptor] = ended_[capture.target] = true;
    end_interceptions_without_targets();
  }
  end_if_over(now + kAfterCapture);
}

void EventLog::end_interceptions_without_targets() {
  const auto is_target = [&](std::size_t i) { return perception_[i].captures == 0 && !ended_[i]; };
  for (std::size_t i = 0; i < ended_.size(); ++i) {
    if (is_target(i)) return;
  }
  ended_.assign(ended_.size(), true);
}

void EventLog::end_if_over(TimeNs end) {
  const bool all_ended = !ended_.empty() && std::all_of(ended_.begin(), ended_.end(), [](bool e) { return e; });
  if (end_of_missions_ < 0 && all_ended) end_of_missions_ = end;
}

void EventLog::note_crash(const Crash& crash) {
  crashed_ = true;
  ended_[crash.vehicle] = true;
  Event event{crash.t, "crash", crash.vehicle, {}, crash.p_world_m, {}};
  if (crash.other_vehicle != kNoVehicle) {
    event.partner = names_[crash.other_vehicle];
  } else {
    event.partner = name_of(crash.surface_class);
    if (crash.instance) event.partner.append(" ").append(std::to_string(crash.instance));
  }
  event.note = fmt::format("at {:.2f} m/s", crash.speed_mps);
  events_.push_back(std::move(event));
}

}  // namespace swiftlet::sim
