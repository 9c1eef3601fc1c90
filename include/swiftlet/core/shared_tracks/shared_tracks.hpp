// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/shared_tracks/shared_tracks_config.hpp"
#include "swiftlet/core/tracking/tracker.hpp"

namespace swiftlet {

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
