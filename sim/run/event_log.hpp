// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "swiftlet/sim/metrics/capture_record.hpp"
#include "swiftlet/sim/metrics/metric.hpp"
#include "swiftlet/sim/physics/physics_world.hpp"
#include "swiftlet/sim/view/tick_view.hpp"

namespace swiftlet::sim {

/// What happened in a tick, and whether all missions have ended.
class EventLog {
 public:
  /// @param perception  by VehicleId: how many captures end a mission
  EventLog(std::vector<std::string> vehicle_names, std::vector<Perception> perception);

  /// Crashes of the tick, then for each vehicle that has not crashed a correction of its local frame and a change of
  /// its mission.
  void collect(TimeNs now, const PhysicsWorld& physics, std::span<const Action* const> actions);
  /// Captures of the tick by true places, after collect(). The last one that an interceptor is to make ends its mission
  /// and that of the target, whatever either believes.
  void note_captures(TimeNs now, const SeriesOf<CaptureRecord>& captures);

  std::span<const Event> of_this_tick() const { return events_; }
  bool crashed() const { return crashed_; }
  /// Every vehicle has crashed or ended its mission, and has flown on for a while so that recordings show it.
  bool all_is_over(TimeNs now) const { return end_of_missions_ >= 0 && now >= end_of_missions_; }

 private:
  void note_crash(const Crash& crash);
  void note_correction(VehicleId i, TimeNs now, const StateEstimate& estimate, const Vector3& p_world_m);
  void note_mission(VehicleId i, TimeNs now, const Action& action, const Vector3& p_world_m);
  void end_hunts_without_targets();
  void end_if_over(TimeNs end);

  std::vector<std::string> names_;
  std::vector<Perception> perception_;
  std::vector<Event> events_;
  std::vector<std::uint32_t> corrections_;  // by vehicle: the last correction_revision
  std::vector<MissionStatus> missions_;
  std::vector<std::string> mission_notes_;
  std::vector<bool> ended_;
  bool crashed_ = false;
  TimeNs end_of_missions_ = -1;
};

}  // namespace swiftlet::sim
