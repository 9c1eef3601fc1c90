// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/run/agent_events.hpp"

#include <fmt/core.h>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet::sim {

void AgentEvents::collect(TimeNs now, const Action& action, const Vector3& p_world_m, std::vector<Event>& events) {
  const StateEstimate& estimate = action.estimate;
  if (estimate.correction_revision != correction_) {
    correction_ = estimate.correction_revision;
    const Vector3& p_m = estimate.T_world_local.translation();
    const double yaw_deg = yaw_of(estimate.T_world_local.linear()) / kRadPerDeg;
    events.push_back({now,
                      "correction",
                      vehicle_,
                      {},
                      p_world_m,
                      fmt::format("the local frame lies at {:.3f}, {:.3f}, {:.3f} m and is turned by {:.2f} deg",
                                  p_m.x(), p_m.y(), p_m.z(), yaw_deg)});
  }
  if (action.mission == mission_ && action.mission_note == note_) return;
  mission_ = action.mission;
  note_ = action.mission_note;
  if (!mission_is_over() && note_.empty()) return;
  const char* kind = mission_ == MissionStatus::kDone     ? "mission_done"
                     : mission_ == MissionStatus::kFailed ? "mission_failed"
                                                          : "mission";
  events.push_back({now, kind, vehicle_, {}, p_world_m, note_});
}

}  // namespace swiftlet::sim
