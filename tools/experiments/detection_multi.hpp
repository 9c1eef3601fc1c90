// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "detection_flights.hpp"

/// Three targets in a hall, one of them behind a wall again and again [Vrba 2025, sec. V-B, Figs. 9 and 10].
namespace swiftlet::tools {

/// Flights of reproduce/detection_multi.yaml with seeds from 1 on, with some changes.
std::vector<sim::Scenario> flights_of_three_targets(int count, double duration_s, const Overrides& changes = {});
/// Flies the scenarios and logs them.
Flights fly_three_targets(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios);

/// Track quality over the flights.
struct ThreeTargets {
  int flights = 0;
  int all_followed = 0;  ///< flights in which each target had a track
  int cross_associations = 0;
  /// Appearances of the moving target from behind the wall, and those in which it is followed again within 5 s.
  int came_out = 0, found_again = 0;
  double error_m = 0.0;          ///< mean position error, in the world that the observer believes in
  double drifted_error_m = 0.0;  ///< as error_m, in the true world
  double speed_error_mps = 0.0, still_speed_error_mps = 0.0, direction_error_rad = 0.0;
  double false_tracks_per_min = 0.0;
};
/// @param csv  receives a row for every flight unless null
ThreeTargets three_targets_of(const Flights& flights, CsvTable* csv = nullptr);

}  // namespace swiftlet::tools
