// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "swiftlet/core/counter.hpp"
#include "swiftlet/core/message.hpp"
#include "swiftlet/core/observation.hpp"
#include "swiftlet/core/overlay.hpp"
#include "swiftlet/core/state_estimate.hpp"

namespace swiftlet {

struct SubmapPoses;

/// Another vehicle, as the agent's own sensors and radio know it. In the local frame.
struct SeenVehicle {
  TimeNs t = 0;
  Vector3 position_local_m = Vector3::Zero();
  Vector3 velocity_local_mps = Vector3::Zero();
};

/// Where am I? A scenario chooses by name who answers. The local frame begins at the start
/// (AgentSetup::T_local_body_start) and stays smooth; what is learned of the world goes into the correction.
class StateEstimator {
 public:
  virtual ~StateEstimator() = default;
  /// Takes in one observation; the state at its time `t`. Samples that are not finite are passed over. The result
  /// belongs to the estimator. Not valid when the sensors that it needs have been silent for too long.
  virtual const StateEstimate& update(const Observation& observation, Outbox& outbox) = 0;
  /// Other vehicles as they were known at the end of the last step: not part of the surroundings that stand still.
  virtual void see(std::span<const SeenVehicle>) {}
  /// Why the estimate is not valid, in a few words; empty while it is.
  virtual const char* fault() const = 0;
  /// What is wrong with an estimate that is still valid, in a few words; empty when all is well.
  virtual const char* warning() const { return ""; }
  /// Does a vehicle that was told nothing of its start look for itself in a map? Until it has found itself, nothing
  /// that is told in the world means anything to it.
  enum class Search { kNone, kLooks, kInVain };
  virtual Search search() const { return Search::kNone; }
  virtual void append_counters(std::vector<Counter>&) const {}
  /// Of one that keeps a pose graph: where its submaps lie as of the last update; null: it keeps none. Stays the
  /// estimator's.
  virtual const SubmapPoses* submap_poses() const { return nullptr; }
  virtual void append_overlays(std::vector<Overlay>&) const {}
};

}  // namespace swiftlet
