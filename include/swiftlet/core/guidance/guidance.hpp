// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <span>

#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/control/motion_limits.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// What guidance is told before the start.
struct GuidanceSetup {
  const AgentSetup& agent;
  MotionLimits limits;  ///< of the reference governor that follows
};

/// What guidance knows in one tick: all values, nothing kept. Everything but what it was told before the start and what
/// neighbors say lies in the local frame.
struct GuidanceInput {
  double dt_s = 0.0;               ///< since the last tick
  const StateEstimate& estimate;   ///< valid
  const Observation& observation;  ///< messages, neighbors, scans
  const LocalPoses& poses;         ///< where the vehicle was in the last seconds
  std::span<const Detection> detections = {};
  std::span<const Track> tracks = {};
  std::span<const TrackModes> track_modes = {};                    ///< of the tracks, when it needs them; may be none
  std::span<const RelativeEstimate> relatives = {};                ///< members of the team
  std::span<const std::shared_ptr<const LocalCloud>> clouds = {};  ///< new in this tick, when it needs them
  const OccupancyView* map = nullptr;                              ///< null: there is none
};

/// What guidance wants in one tick, in the local frame. Owned by the caller, reused.
struct GuidanceOutput {
  Reference goal;                 ///< the reference governor makes it flyable
  bool goal_is_feasible = false;  ///< it keeps the motion limits already and is flown as it is
  double speed_limit_mps = std::numeric_limits<double>::infinity();  ///< lower than the governor's, for now
  bool motors_on = true;
  MissionStatus mission = MissionStatus::kRunning;
  const char* note = "";  ///< why it failed, or what it waits for
};

/// What guidance asks of the stages before it.
struct GuidanceNeeds {
  bool clouds = false;
  bool map = false;
  bool relatives = false;  ///< where the other members of the team are
  bool track_modes = false;
  bool neighbors = false;  ///< it keeps from those that a sensor of neighbors sees, so the map need not show them
  bool world = true;  ///< goals, limits or neighbors of the world: it waits until the vehicle has found itself there
};

/// Where should I go? A scenario chooses by name who answers. Goals of the world are carried into
/// the local frame anew in every tick: the correction may have changed.
class Guidance {
 public:
  virtual ~Guidance() = default;
  virtual GuidanceNeeds needs() const { return {}; }
  virtual void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) = 0;
  /// What may help to understand it in a picture; called only when one is taken.
  virtual void append_overlays(std::vector<Overlay>&) const {}
  virtual void append_counters(std::vector<Counter>&) const {}
};

}  // namespace swiftlet
