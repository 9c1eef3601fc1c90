// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/stage_tables/trackers.hpp"

#include "swiftlet/core/shared_tracks/shared_tracks.hpp"
#include "swiftlet/core/tracking/trackers.hpp"

namespace swiftlet {
namespace {

void request_track_scores(const ModuleConfig&, AgentNeeds& needs) { needs.tracks = true; }

void need_neighbors_to_track(const ModuleConfig&, AgentNeeds& needs) { needs.tracks = needs.true_neighbors = true; }

constexpr TrackerType kTrackerTypes[] = {
    {{"none", "no tracking", make_module_config<NoTrackerConfig>}, make_no_tracker},
    {{"vofod", "follows detections through the LiDAR's clouds with a Kalman filter [Vrba 2025, algorithm 2]",
      make_module_config<VofodTrackerConfig>},
     make_vofod_tracker,
     request_track_scores},
    {{"imm", "like vofod, with interacting multiple models: constant velocity, constant acceleration, coordinated turn",
      make_module_config<ImmTrackerConfig>},
     make_imm_tracker,
     request_track_scores},
    {{"detector", "passes on the tracks of a track-before-detect detector", make_module_config<DetectorTracksConfig>},
     make_detector_tracks,
     request_track_scores},
    {{"shared", "tracks of track-before-detect detectors on several vehicles, shared by radio and fused",
      make_module_config<SharedTracksConfig>},
     make_shared_tracks,
     request_track_scores},
    {{"ground_truth", "tracks from a mutual-localization sensor; an ideal sensor is added if the vehicle has none",
      make_module_config<GroundTruthTrackerConfig>},
     make_ground_truth_tracker,
     need_neighbors_to_track},
};

}  // namespace

Registry<TrackerType>& tracker_registry() {
  static Registry<TrackerType> table("tracker", kTrackerTypes);
  return table;
}

std::unique_ptr<Tracker> make_tracker(const Module& config, const AgentSetup& setup) {
  return tracker_registry().make(config, setup);
}

}  // namespace swiftlet
