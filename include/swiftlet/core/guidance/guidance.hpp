// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <span>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/control/motion_limits.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// Data that guidance receives before the start.
struct GuidanceSetup {
  const AgentSetup& agent;
  MotionLimits limits;  ///< limits of the reference governor, the next stage
};

/// Inputs of guidance in one tick; references are valid for this call only. All quantities are in the local frame,
/// except those from the setup and from messages of neighbors.
struct GuidanceInput {
  double dt_s = 0.0;               ///< time since the last tick
  const StateEstimate& estimate;   ///< valid
  const Observation& observation;  ///< messages, neighbors, scans
  const LocalPoses& poses;         ///< poses of the vehicle in the last seconds
  std::span<const Detection> detections = {};
  std::span<const Track> tracks = {};
  std::span<const TrackModes> track_modes = {};      ///< modes of the tracks, if requested by needs(); may be empty
  std::span<const RelativeEstimate> relatives = {};  ///< estimates of teammates
  std::span<const std::shared_ptr<const LocalCloud>> clouds = {};  ///< finished in this tick, if requested by needs()
  const OccupancyView* map = nullptr;                              ///< null: no map
};

/// Outputs of guidance in one tick, in the local frame. Owned by the caller, reused.
struct GuidanceOutput {
  Reference goal;                 ///< limited by the reference governor
  bool goal_is_feasible = false;  ///< the goal keeps the motion limits and bypasses the governor
  double speed_limit_mps = std::numeric_limits<double>::infinity();  ///< current speed limit, if below the governor's
  bool motors_on = true;
  MissionStatus mission = MissionStatus::kRunning;
  const char* note = "";  ///< reason of a failure or a wait
};

/// Inputs that guidance requires from earlier stages.
struct GuidanceNeeds {
  bool clouds = false;
  bool map = false;
  bool relatives = false;  ///< estimates of teammates
  bool track_modes = false;
  bool neighbors = false;  ///< guidance avoids neighbors seen by a mutual-localization sensor, so the map may omit them
  bool world = true;       ///< uses the world frame, so guidance waits until the vehicle is localized in it
};

/// Interface of guidance: decides where the vehicle flies. A scenario selects the implementation by name. Goals in the
/// world frame are transformed into the local frame in every tick, because the correction may change.
class Guidance {
 public:
  virtual ~Guidance() = default;
  virtual GuidanceNeeds needs() const { return {}; }
  virtual void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) = 0;
  /// Geometry for debugging in pictures; called only when a snapshot is taken.
  virtual void append_overlays(std::vector<Overlay>&) const {}
  virtual void append_counters(std::vector<Counter>&) const {}
};

}  // namespace swiftlet
