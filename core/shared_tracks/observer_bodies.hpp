// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/shared_tracks/track_fusion.hpp"
#include "swiftlet/core/shared_tracks/shared_tracks_config.hpp"

namespace swiftlet {

/// Tracks whose target is itself an observer. A track is marked as an observer while its motion
/// matches that of the observer.
class ObserverBodies {
 public:
  explicit ObserverBodies(const SharedTracksConfig& config) : gate_sq_(config.fusion.gate_sq) {}

  void forget_before(TimeNs oldest);
  /// Marks the tracks of each observer that are this vehicle. `tracks` is ordered by observer.
  void mark(VehicleId vehicle, const MotionEstimate& place, TimeNs t, std::span<const ObservedTrack> tracks);
  bool contain(const ObservedTrack& track) { return body_of(track) != bodies_.end(); }

 private:
  struct Body {
    VehicleId observer = kNoVehicle;
    std::uint32_t identity = 0;
    VehicleId vehicle = kNoVehicle;
    TimeNs last = 0;
  };

  std::vector<Body>::iterator body_of(const ObservedTrack& track);
  void mark_body(const ObservedTrack& track, VehicleId vehicle, TimeNs t);

  double gate_sq_;  // squared Mahalanobis distance up to which a track is an observer
  std::vector<Body> bodies_;
};

}  // namespace swiftlet
