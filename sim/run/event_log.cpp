// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/event_log.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet::sim {
namespace {

// Time for which the run continues after the last mission has ended, so that recordings show the end.
constexpr TimeNs kAfterTheEnd = kNsPerSecond / 2;
// Longer after a capture, so that recordings show the interceptor's reaction.
constexpr TimeNs kAfterCapture = kNsPerSecond;

}  // namespace

EventLog::EventLog(std::vector<std::string> vehicle_names, std::vector<Perception> perception)
    : names_(std::move(vehicle_names)),
      perception_(std::move(perception)),
      corrections_(names_.size(), 0),
      missions_(names_.size(), MissionStatus::kRunning),
      mission_notes_(names_.size()),
      ended_(names_.size(), false) {}

void EventLog::collect(TimeNs now, const PhysicsWorld& physics, std::span<const Action* const> actions) {
  events_.clear();
  for (const Crash& crash : physics.crashes()) note_crash(crash);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const auto vehicle = static_cast<VehicleId>(i);
    const VehicleState& state = physics.state(vehicle);
    if (state.crashed) continue;  // estimates of a crashed vehicle's agent are ignored
    note_correction(vehicle, now, actions[i]->estimate, state.p_world_m);
    note_mission(vehicle, now, *actions[i], state.p_world_m);
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

void EventLog::note_correction(VehicleId i, TimeNs now, const StateEstimate& estimate, const Vector3& p_world_m) {
  if (estimate.correction_revision == corrections_[i]) return;
  corrections_[i] = estimate.correction_revision;
  const Vector3& p_m = estimate.T_world_local.translation();
  const double yaw_deg = yaw_of(estimate.T_world_local.linear()) / kRadPerDeg;
  events_.push_back({now,
                     "correction",
                     i,
                     {},
                     p_world_m,
                     fmt::format("the local frame lies at {:.3f}, {:.3f}, {:.3f} m and is turned by {:.2f} deg",
                                 p_m.x(), p_m.y(), p_m.z(), yaw_deg)});
}

void EventLog::note_mission(VehicleId i, TimeNs now, const Action& action, const Vector3& p_world_m) {
  if (action.mission == missions_[i] && action.mission_note == mission_notes_[i]) return;
  missions_[i] = action.mission;
  mission_notes_[i] = action.mission_note;
  const bool over = action.mission == MissionStatus::kDone || action.mission == MissionStatus::kFailed;
  ended_[i] = ended_[i] || over;
  if (!over && action.mission_note.empty()) return;
  const char* status = action.mission == MissionStatus::kDone     ? "mission_done"
                       : action.mission == MissionStatus::kFailed ? "mission_failed"
                                                                  : "mission";
  events_.push_back({now, status, i, {}, p_world_m, action.mission_note});
}

}  // namespace swiftlet::sim
