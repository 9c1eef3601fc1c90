// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "detection_flights.hpp"

/// Three targets in a hall, one of them behind a wall again and again [Vrba 2025, sec. V-B, Figs. 9 and 10].
namespace swiftlet::tools {

/// Flights of reproduce/detection_multi.yaml with seeds from 1 on, with some changes.
std::vector<sim::Scenario> flights_of_three_targets(int count, double duration_s, const Overrides& changes = {});
/// All of them with their logs.
Flights fly_three_targets(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios);

/// What the flights say of the tracks.
struct ThreeTargets {
  int flights = 0;
  int all_followed = 0;  ///< flights in which each target had a track
  int cross_associations = 0;
  int came_out = 0, found_again = 0;  ///< the moving one from behind the wall; followed again within 5 s
  double error_m = 0.0;               ///< of positions, in the world that the observer believes in
  double drifted_error_m = 0.0;       ///< the same in the true world
  double speed_error_mps = 0.0, still_speed_error_mps = 0.0, direction_error_rad = 0.0;
  double false_tracks_per_min = 0.0;
};
/// @param csv  a row for every flight, if wanted
ThreeTargets three_targets_of(const Flights& flights, CsvTable* csv = nullptr);

}  // namespace swiftlet::tools
