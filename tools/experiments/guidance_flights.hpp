// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "experiment.hpp"
#include "swiftlet/core/frames.hpp"
#include "swiftlet/core/guidance/guide.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

/// Flights of a vehicle that guides another one [Pritzl 2024], and what is noted of them.
namespace swiftlet::tools {

/// A passage in a wall: its center, and the direction through it.
struct Passage {
  double x_world_m = 0.0, y_world_m = 0.0, yaw_rad = 0.0;

  /// Of a place: along the way through the passage, and across it.
  Eigen::Vector2d of(const Vector3& p_world_m) const;
};

/// What came of one flight. The vehicle that is to pass is the last one of the scenario.
struct GuidedFlight {
  bool done = false;     ///< all goals reached
  bool crashed = false;  ///< somebody touched something
  double time_s = 0.0;
  int passes = 0;                  ///< of the passage, from one side to the other
  double farthest_m = 0.0;         ///< from where it was when it was first guided, horizontally
  double least_clearance_m = 0.0;  ///< of any vehicle to any surface
  // Errors of its place in the guide's estimate, within 1 m of the passage.
  double error_sum_m = 0.0, along_wall_sum_m = 0.0;
  int num_errors = 0;
  double seen_s = 0.0, guided_s = 0.0;  ///< while it was told a path: with sightings not older than 0.3 s, and in all
};

/// The scenarios end at the first contact; nothing is recorded.
std::vector<GuidedFlight> fly_guided(const Experiment& experiment, std::vector<sim::Scenario> scenarios,
                                     const std::vector<Passage>& passages);

/// The guide's own configuration; it is the first vehicle.
GuideConfig& guide_of(sim::Scenario& scenario);

/// Place of a point in a building whose passage lies there: along it and across it.
Vector3 in_world(const Passage& passage, double along_m, double across_m, double height_m);
std::string text_of(const Vector3& p_world_m);

/// Interval of Wilson for a share, 95 %.
struct ShareInterval {
  double low = 0.0, high = 1.0;
};
ShareInterval wilson(int successes, int attempts);

}  // namespace swiftlet::tools
