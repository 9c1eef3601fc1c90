// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <span>

#include "core/control/motion_limits.hpp"
#include "swiftlet/core/agent.hpp"

namespace swiftlet {

/// What guidance is told before the start.
struct GuidanceSetup {
  const AgentSetup& agent;
  MotionLimits limits;  ///< of the reference tracker that follows
};

/// What guidance knows in one tick: all values, nothing kept.
struct GuidanceInput {
  double dt_s = 0.0;               ///< since the last tick
  const StateEstimate& estimate;   ///< valid
  const Observation& observation;  ///< messages, neighbors, scans
  std::span<const Detection> detections = {};
  std::span<const Track> tracks = {};
};

/// What guidance wants in one tick. Owned by the caller, reused.
struct GuidanceOutput {
  Reference goal;                                                    ///< the reference tracker makes it flyable
  double speed_limit_mps = std::numeric_limits<double>::infinity();  ///< lower than the tracker's, for now
  bool motors_on = true;
  MissionStatus mission = MissionStatus::kRunning;
  const char* note = "";          ///< why it failed, or what it waits for
  std::vector<Message> messages;  ///< to other vehicles; cleared by the caller
};

/// Where should I go? One of the ways of answering that a scenario chooses by name.
class Guidance {
 public:
  virtual ~Guidance() = default;
  virtual void step(const GuidanceInput& input, GuidanceOutput& output) = 0;
  /// What may help to understand it in a picture; called only when one is taken.
  virtual void append_overlays(std::vector<Overlay>&) const {}
};

}  // namespace swiftlet
