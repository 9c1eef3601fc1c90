// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/base/observation.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/background_query.hpp"

namespace swiftlet {

/// Inputs of a tracker in one tick; references are valid for this call only.
struct TrackerInput {
  const Observation& observation;
  const StateEstimate& estimate;                                   ///< valid
  std::span<const std::shared_ptr<const LocalCloud>> clouds = {};  ///< finished in this tick
  bool has_detections = false;                                     ///< the detector finished a scan in this tick
  std::span<const Detection> detections = {};                      ///< detections of that scan; may be empty
  std::span<const Track> detector_tracks = {};  ///< tracks of a track-before-detect detector, as of its last scan
  const BackgroundQuery* background = nullptr;  ///< occupied voxels of the detector's map; null: unknown
};

/// Interface of trackers. A scenario selects the implementation by name.
class Tracker {
 public:
  virtual ~Tracker() = default;
  /// True when `tracks` was updated; otherwise it is unchanged.
  virtual bool step(const TrackerInput& input, std::vector<Track>& tracks, Outbox& outbox) = 0;
  /// Mode estimates of the tracks of the last update, in their order. Empty with one model.
  virtual void modes(std::vector<TrackModes>& modes) const { modes.clear(); }
  /// Present states of observers with which tracks are shared; none otherwise. Local frame.
  virtual void append_relatives(TimeNs /*t*/, std::vector<RelativeEstimate>& /*relatives*/) const {}
  /// Appends counters of events that exceeded the settings.
  virtual void append_counters(std::vector<Counter>& /*counters*/) const {}
};

}  // namespace swiftlet
