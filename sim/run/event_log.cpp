// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/event_log.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet::sim {
namespace {

// A mission that has ended is flown on for this long.
constexpr TimeNs kAfterTheEnd = kNsPerSecond / 2;

}  // namespace

EventLog::EventLog(std::vector<std::string> vehicle_names)
    : names_(std::move(vehicle_names)),
      corrections_(names_.size(), 0),
      missions_(names_.size(), MissionStatus::kRunning),
      mission_notes_(names_.size()),
      ended_(names_.size(), false) {}

void EventLog::collect(TimeNs now, const PhysicsWorld& physics, std::span<const Action* const> actions) {
  events_.clear();
  for (const Crash& crash : physics.crashes()) note_crash(crash);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const auto vehicle = static_cast<VehicleId>(i);
    note_correction(vehicle, now, actions[i]->estimate, physics.state(vehicle).p_world_m);
    note_mission(vehicle, now, *actions[i], physics.state(vehicle).p_world_m);
  }
  const bool all_ended = !ended_.empty() && std::all_of(ended_.begin(), ended_.end(), [](bool e) { return e; });
  if (end_of_missions_ < 0 && all_ended) end_of_missions_ = now + kAfterTheEnd;
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
  event.note = "at " + std::to_string(crash.speed_mps) + " m/s";
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
