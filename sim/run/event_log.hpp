// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "swiftlet/sim/metrics/capture_record.hpp"
#include "swiftlet/sim/metrics/metric.hpp"
#include "swiftlet/sim/physics/physics_world.hpp"
#include "swiftlet/sim/recording/tick_view.hpp"
#include "swiftlet/sim/run/agent_events.hpp"

namespace swiftlet::sim {

/// Collects the events of a tick and detects the end of all missions.
class EventLog {
 public:
  /// @param perception  indexed by VehicleId: number of captures that ends a mission
  EventLog(std::vector<std::string> vehicle_names, std::vector<Perception> perception);

  /// Adds crashes of the tick, then for each vehicle that has not crashed corrections of its local frame and changes of
  /// its mission status.
  void collect(TimeNs now, const PhysicsWorld& physics, std::span<const Action* const> actions);
  /// Adds captures of the tick, from true positions; call after collect(). An interceptor's last required capture ends
  /// its mission and that of the target, independent of their estimates.
  void note_captures(TimeNs now, const SeriesOf<CaptureRecord>& captures);

  std::span<const Event> of_this_tick() const { return events_; }
  bool crashed() const { return crashed_; }
  /// True some time after every vehicle has crashed or ended its mission, so that recordings show the end.
  bool all_is_over(TimeNs now) const { return end_of_missions_ >= 0 && now >= end_of_missions_; }

 private:
  void note_crash(const Crash& crash);
  void end_interceptions_without_targets();
  void end_if_over(TimeNs end);

  std::vector<std::string> names_;
  std::vector<Perception> perception_;
  std::vector<Event> events_;
  std::vector<AgentEvents> agents_;  // indexed by vehicle
  std::vector<bool> ended_;
  bool crashed_ = false;
  TimeNs end_of_missions_ = -1;
};

}  // namespace swiftlet::sim
