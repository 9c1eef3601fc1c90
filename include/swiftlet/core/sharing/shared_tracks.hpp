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

/// Several observers of the same targets, each with a detector that tracks before it detects; docs/detection.md.
struct SharedTracksConfig : ModuleConfigOf<SharedTracksConfig> {
  double rate_hz = 5.0;
  int max_told = 16;
  double tell_existence = 0.1;
  double certainty = 0.9;
  double timeout_s = 1.0;
  double acceleration_density = 3.0;
  double body_m = 0.8;
  FrameLinkConfig frame;
  OdometryDriftConfig drift;
  TrackFusionConfig fusion;

  void visit(ConfigVisitor& v) override;
};

/// Own tracks and those that others tell by radio (`ToldTracks`), as one list in the own local frame. Nothing of an
/// observer is fused before it is known where its frame lies (`FrameLink`). Observers are no targets: a track that is
/// one of them is left out, and where they are is told as `RelativeEstimate`.
///
/// What is told together holds for the instant of the newest track, and is told anew after every scan of the own
/// detector. Whole states are told, so a message that comes after a newer one adds nothing and is passed over. One that
/// is late is as good as its age. A sender that falls silent counts for `timeout_s`.
std::unique_ptr<Tracker> make_shared_tracks(const ModuleConfig& config, const AgentSetup& setup);
/// The same about a tracker of one's own. Without a detector that tells existences, its tracks count as `certainty`.
std::unique_ptr<Tracker> make_shared_tracks(const SharedTracksConfig& config, const AgentSetup& setup,
                                            std::unique_ptr<Tracker> own);

}  // namespace swiftlet
