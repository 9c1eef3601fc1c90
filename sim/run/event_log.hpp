// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "swiftlet/sim/physics/physics_world.hpp"
#include "swiftlet/sim/view/tick_view.hpp"

namespace swiftlet::sim {

/// What happened in a tick, and whether all missions have ended.
class EventLog {
 public:
  explicit EventLog(std::vector<std::string> vehicle_names);

  /// Crashes of the tick, then for each vehicle a correction of its local frame and a change of its mission.
  void collect(TimeNs now, const PhysicsWorld& physics, std::span<const Action* const> actions);

  std::span<const Event> of_this_tick() const { return events_; }
  bool crashed() const { return crashed_; }
  /// Every vehicle has crashed or ended its mission, and has flown on for a while so that recordings show it.
  bool all_is_over(TimeNs now) const { return end_of_missions_ >= 0 && now >= end_of_missions_; }

 private:
  void note_crash(const Crash& crash);
  void note_correction(VehicleId i, TimeNs now, const StateEstimate& estimate, const Vector3& p_world_m);
  void note_mission(VehicleId i, TimeNs now, const Action& action, const Vector3& p_world_m);

  std::vector<std::string> names_;
  std::vector<Event> events_;
  std::vector<std::uint32_t> corrections_;  // by vehicle: the last correction_revision
  std::vector<MissionStatus> missions_;
  std::vector<std::string> mission_notes_;
  std::vector<bool> ended_;
  bool crashed_ = false;
  TimeNs end_of_missions_ = -1;
};

}  // namespace swiftlet::sim
