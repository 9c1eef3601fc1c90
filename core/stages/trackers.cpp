// SPDX-License-Identifier: BSD-3-Clause
#include "core/stages/trackers.hpp"

#include "core/tracking/trackers.hpp"
#include "swiftlet/core/registry.hpp"

namespace swiftlet {
namespace {

void need_scores(const ModuleConfig&, AgentNeeds& needs) { needs.tracks = true; }

void need_neighbors_to_track(const ModuleConfig&, AgentNeeds& needs) { needs.tracks = needs.true_neighbors = true; }

constexpr TrackerType kTrackerTypes[] = {
    {{"none", "no tracking", make_module_config<NoTrackerConfig>}, make_no_tracker},
    {{"vofod", "follows detections through the LiDAR's clouds with a Kalman filter [Vrba 2025, algorithm 2]",
      make_module_config<VofodTrackerConfig>},
     make_vofod_tracker,
     need_scores},
    {{"imm", "the same with interacting multiple models: constant velocity, constant acceleration, coordinated turn",
      make_module_config<ImmTrackerConfig>},
     make_imm_tracker,
     need_scores},
    {{"ground_truth", "tracks from the mutual-localization sensor, an ideal one when there is none",
      make_module_config<GroundTruthTrackerConfig>},
     make_ground_truth_tracker,
     need_neighbors_to_track},
};

}  // namespace

std::span<const TrackerType> tracker_types() { return kTrackerTypes; }

std::span<const ModuleType> tracker_module_types() { return module_types_of<kTrackerTypes>(); }

std::unique_ptr<Tracker> make_tracker(const Module& config, const AgentSetup& setup) {
  return row_named(kTrackerTypes, config.type, "tracker").make(*config.config, setup);
}

void add_tracker_needs(const Module& config, AgentNeeds& needs) {
  const TrackerType& row = row_named(kTrackerTypes, config.type, "tracker");
  if (row.add_needs != nullptr) row.add_needs(*config.config, needs);
}

}  // namespace swiftlet
