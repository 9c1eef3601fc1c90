// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/sharing/frame_link.hpp"
#include "swiftlet/core/sharing/track_fusion.hpp"
#include "swiftlet/core/tracking/tracker.hpp"

namespace swiftlet {

/// Several observers of the same targets, each with a track-before-detect detector; docs/detection.md.
struct SharedTracksConfig : ModuleConfigOf<SharedTracksConfig> {
  double rate_hz = 5.0;
  int max_told = 16;  ///< [-] largest number of tracks in a message, the likeliest first; 120 bytes each
  double tell_existence = 0.1;
  double certainty = 0.9;  ///< [-] probability of existence of own tracks whose detector reports none
  double timeout_s = 1.0;
  double acceleration_density = 3.0;  ///< [m^2/s^3] white acceleration of a target by axis, since the track's report
  double body_m = 0.8;
  FrameLinkConfig frame;
  OdometryDriftConfig drift;
  TrackFusionConfig fusion;

  void visit(ConfigVisitor& v) override;
};

/// Own tracks and tracks received by radio (`TrackReport`), fused in the own local frame. Tracks of an observer are
/// used once the pose of its frame is known (`FrameLink`). Observers are not targets: their tracks are removed, and
/// their states are reported as `RelativeEstimate`.
///
/// The fused tracks hold for the time of the newest track, and are updated after every scan of the own detector.
/// Messages contain whole states, so one older than the newest received is ignored, and a delayed one is only less
/// accurate. The tracks of a silent sender are used for `timeout_s`.
std::unique_ptr<Tracker> make_shared_tracks(const ModuleConfig& config, const AgentSetup& setup);
/// Shares the tracks of a custom tracker. Without existence probabilities from a detector, its tracks have `certainty`.
std::unique_ptr<Tracker> make_shared_tracks(const SharedTracksConfig& config, const AgentSetup& setup,
                                            std::unique_ptr<Tracker> own);

}  // namespace swiftlet
