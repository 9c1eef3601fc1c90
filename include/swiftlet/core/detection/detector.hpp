// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/voxel_map.hpp"
#include "swiftlet/core/track.hpp"

namespace swiftlet {

/// What a detector gets in one tick.
struct DetectorInput {
  TimeNs t = 0;                                               ///< now
  const StateEstimate& estimate;                              ///< valid
  const LocalPoses& poses;                                    ///< where the vehicle was in the last seconds
  std::span<const std::shared_ptr<const LocalCloud>> clouds;  ///< new in this tick
  const Observation& observation;
};

/// What it gives: has_detections and the stamp say which scan was finished, even if nothing was found in it.
struct DetectorOutput {
  bool has_detections = false;
  TimeNs stamp = 0;                   ///< start of the sweep of that scan
  std::vector<Detection> detections;  ///< keeps its memory

  void clear() {
    has_detections = false;
    detections.clear();
  }
};

/// Finds flying objects. Slow modules inside work at their own rates with configured latencies: `step` is called every
/// tick and gives what is ready by then. No result depends on how fast the machine is.
class Detector {
 public:
  virtual ~Detector() = default;
  /// Adds to the output what became ready since the last call.
  virtual void step(const DetectorInput& input, DetectorOutput& output, Outbox& outbox) = 0;
  /// The map that it keeps, as of now; null when it keeps none.
  virtual const VoxelMap* map() const { return nullptr; }
  /// What a detector that tracks before it detects follows, as of the last scan that it finished; none otherwise. Local
  /// frame. Track i is that of detection i of that scan.
  virtual std::span<const Track> tracks() const { return {}; }
  virtual void append_overlays(std::vector<Overlay>&) const {}
  /// What did not fit its settings so far.
  virtual void append_counters(std::vector<Counter>&) const {}
};

}  // namespace swiftlet
