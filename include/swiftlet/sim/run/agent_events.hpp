// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/sim/recording/tick_view.hpp"

namespace swiftlet::sim {

/// Events that the software of one vehicle reports by its actions: corrections of its local frame, and changes of its
/// mission status and of the note on it.
class AgentEvents {
 public:
  explicit AgentEvents(VehicleId vehicle) : vehicle_(vehicle) {}

  /// Appends the events of a tick. @param p_world_m  position recorded with them
  void collect(TimeNs now, const Action& action, const Vector3& p_world_m, std::vector<Event>& events);
  bool mission_is_over() const { return mission_ == MissionStatus::kDone || mission_ == MissionStatus::kFailed; }

 private:
  VehicleId vehicle_;
  std::uint32_t correction_ = 0;  // last correction_revision
  MissionStatus mission_ = MissionStatus::kRunning;
  std::string note_;
};

}  // namespace swiftlet::sim
