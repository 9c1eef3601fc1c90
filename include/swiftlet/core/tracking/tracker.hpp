// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/counter.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/background_query.hpp"
#include "swiftlet/core/observation.hpp"

namespace swiftlet {

/// What a tracker knows in one tick: all values, nothing kept.
struct TrackerInput {
  const Observation& observation;
  const StateEstimate& estimate;                                   ///< valid
  std::span<const std::shared_ptr<const LocalCloud>> clouds = {};  ///< new in this tick
  bool has_detections = false;                                     ///< the detector finished a scan in this tick
  std::span<const Detection> detections = {};                      ///< what it found, which may be nothing
  std::span<const Track> detector_tracks = {};  ///< of a detector that tracks before it detects, as of its last scan
  const BackgroundQuery* background = nullptr;  ///< occupied voxels of the detector's map; null: nothing is known
};

/// Where do the targets fly? A scenario chooses by name who answers.
class Tracker {
 public:
  virtual ~Tracker() = default;
  /// True when `tracks` was updated; it is left alone otherwise.
  virtual bool step(const TrackerInput& input, std::vector<Track>& tracks, Outbox& outbox) = 0;
  /// What its motion models believe of the tracks that it told last, in their order. None where it has one model.
  virtual void modes(std::vector<TrackModes>& modes) const { modes.clear(); }
  /// Where other observers are with whom it shares tracks, as of now; none otherwise. Local frame.
  virtual void append_relatives(TimeNs /*t*/, std::vector<RelativeEstimate>& /*relatives*/) const {}
  /// What did not fit its settings so far.
  virtual void append_counters(std::vector<Counter>& /*counters*/) const {}
};

}  // namespace swiftlet
