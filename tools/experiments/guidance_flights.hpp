// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "experiment.hpp"
#include "swiftlet/core/frames.hpp"
#include "swiftlet/core/guidance/guide.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

/// Flights of a vehicle that guides another one [Pritzl 2024], and their results.
namespace swiftlet::tools {

/// A passage in a wall: its center, and the direction through it.
struct Passage {
  double x_world_m = 0.0, y_world_m = 0.0, yaw_rad = 0.0;

  /// Coordinates of a point along the passage and across it.
  Eigen::Vector2d of(const Vector3& p_world_m) const;
};

/// Result of one flight. The vehicle that has to pass is the scenario's last one.
struct GuidedFlight {
  bool done = false;     ///< all goals reached
  bool crashed = false;  ///< any vehicle had a contact
  double time_s = 0.0;
  int passes = 0;                  ///< number of crossings of the passage
  double farthest_m = 0.0;         ///< largest horizontal distance from where guidance begins
  double least_clearance_m = 0.0;  ///< least over vehicles and surfaces
  // Error of the guide's estimate of its position, within 1 m of the passage.
  double error_sum_m = 0.0, along_wall_sum_m = 0.0;
  int num_errors = 0;
  /// Time on a path from the guide: with sightings no older than 0.3 s, and in all.
  double seen_s = 0.0, guided_s = 0.0;
};

/// The scenarios end at the first contact; nothing is recorded.
std::vector<GuidedFlight> fly_guided(const Experiment& experiment, std::vector<sim::Scenario> scenarios,
                                     const std::vector<Passage>& passages);

/// The guide's own configuration; it is the first vehicle.
GuideConfig& guide_of(sim::Scenario& scenario);

/// World position of a point given along and across a passage.
Vector3 in_world(const Passage& passage, double along_m, double across_m, double height_m);
std::string text_of(const Vector3& p_world_m);

/// Wilson score interval of a share, 95 %.
struct ShareInterval {
  double low = 0.0, high = 1.0;
};
ShareInterval wilson(int successes, int attempts);

}  // namespace swiftlet::tools
