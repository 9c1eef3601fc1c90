// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/base/message.hpp"
#include "swiftlet/core/base/observation.hpp"
#include "swiftlet/core/base/overlay.hpp"
#include "swiftlet/core/base/state_estimate.hpp"

namespace swiftlet {

struct SubmapPoses;

/// Another vehicle observed by the agent's sensors and radio. Local frame.
struct SeenVehicle {
  TimeNs t = 0;
  Vector3 position_local_m = Vector3::Zero();
  Vector3 velocity_local_mps = Vector3::Zero();
};

/// Interface of state estimators. A scenario selects the implementation by name. The local frame begins at the start
/// pose (AgentSetup::T_local_body_start) and stays smooth; information about the world changes only the correction.
class StateEstimator {
 public:
  virtual ~StateEstimator() = default;
  /// Processes one observation; returns the state at its time `t`. Samples that are not finite are ignored. The result
  /// belongs to the estimator. Not valid when required sensors have been silent for too long.
  virtual const StateEstimate& update(const Observation& observation, Outbox& outbox) = 0;
  /// Other vehicles as of the end of the last step, to be excluded from the static surroundings.
  virtual void see(std::span<const SeenVehicle>) {}
  /// Short reason why the estimate is not valid; empty while it is.
  virtual const char* fault() const = 0;
  /// Short description of a degradation while the estimate is still valid; empty otherwise.
  virtual const char* warning() const { return ""; }
  /// Whether the position will be lost soon unless the vehicle returns to where its sensors saw enough.
  virtual bool should_return() const { return false; }
  /// State of global relocalization in a prior map, for a vehicle with an unknown start pose. Until it succeeds, the
  /// vehicle cannot use positions in the world frame.
  enum class Search { kNone, kActive, kFailed };
  virtual Search search() const { return Search::kNone; }
  virtual void append_counters(std::vector<Counter>&) const {}
  /// Submap poses of an estimator with a pose graph, as of the last update; null: no pose graph. Owned by the
  /// estimator.
  virtual const SubmapPoses* submap_poses() const { return nullptr; }
  virtual void append_overlays(std::vector<Overlay>&) const {}
};

}  // namespace swiftlet
