// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/track.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/voxel_map.hpp"

namespace swiftlet {

/// Inputs of a detector in one tick.
struct DetectorInput {
  TimeNs t = 0;                                               ///< current time
  const StateEstimate& estimate;                              ///< valid
  const LocalPoses& poses;                                    ///< poses of the vehicle in the last seconds
  std::span<const std::shared_ptr<const LocalCloud>> clouds;  ///< finished in this tick
  const Observation& observation;
};

/// Outputs of a detector. has_detections and the stamp identify the finished scan, even if it has no detections.
struct DetectorOutput {
  bool has_detections = false;
  TimeNs stamp = 0;                   ///< start of the sweep of that scan
  std::vector<Detection> detections;  ///< keeps its capacity

  void clear() {
    has_detections = false;
    detections.clear();
  }
};

/// Detects flying objects. Slow modules inside run at their own rates with configured latencies: `step` is called every
/// tick and returns results whose latency has elapsed. Results do not depend on the speed of the machine.
class Detector {
 public:
  virtual ~Detector() = default;
  /// Appends the results whose latency has elapsed since the last call.
  virtual void step(const DetectorInput& input, DetectorOutput& output, Outbox& outbox) = 0;
  /// Map of the detector, as of now; null when there is none.
  virtual const VoxelMap* map() const { return nullptr; }
  /// Tracks of a track-before-detect detector, as of its last finished scan; empty otherwise. Local frame. Track i
  /// belongs to detection i of that scan.
  virtual std::span<const Track> tracks() const { return {}; }
  virtual void append_overlays(std::vector<Overlay>&) const {}
  /// Appends counters of events that exceeded the settings.
  virtual void append_counters(std::vector<Counter>&) const {}
};

}  // namespace swiftlet
