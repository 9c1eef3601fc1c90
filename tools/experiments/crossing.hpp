// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "parallel.hpp"

/// Crossings of a circle or a sphere [Kamler 2025, sec. 2.4], shared by the experiments of that document.
namespace swiftlet::tools {

struct Formation {
  bool sphere = false;
  int num_vehicles = 10;
  double radius_m = 10.0;
  bool poles = false;  ///< sphere only: the first and the last vehicle start at the poles
};

/// Scenario in which each vehicle flies to the opposite side. All vehicles are copies of the pattern's first one; the
/// scenario's seed moves their starts by up to 0.1 m. Guidance must have a `goal_m`: rbl, pacnav or mezey.
sim::Scenario make_crossing(const sim::Scenario& pattern, const Formation& formation, double height_m);

/// Sets `goal_m` of the vehicle's guidance.
void set_goal(sim::VehicleConfig& vehicle, const Eigen::Vector3d& goal_m);

/// One flight, as Table "N = ..." of the document counts it: until each vehicle reaches its goal.
struct CrossingResult {
  std::vector<double> length_m, time_s;  ///< path length and flight time of each vehicle that arrived
  int num_arrived = 0;
  bool crashed = false;
  double min_separation_m = 0.0;
  /// Least distance of the rbl vehicles to the intruder (the vehicle that flies straight through by waypoints), and how
  /// long the vehicle at that distance had measured the intruder by then. Infinite without an intruder.
  double stranger_m = std::numeric_limits<double>::infinity(), warned_s = 0.0;
};
std::vector<CrossingResult> fly_crossings(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios);

/// The columns of the document's tables over many flights.
struct CrossingTable {
  double success = 0.0;  ///< share of flights without contact in which all vehicles arrive
  double arrived = 0.0;  ///< share of all vehicles that arrive
  double crashed = 0.0;  ///< share of flights with a contact
  MeanAndDeviation length_m, time_s, slowest_s, speed_mps;
  double min_separation_m = 0.0;  ///< least over all flights
};
CrossingTable summarize(const std::vector<CrossingResult>& flights, int num_vehicles);

}  // namespace swiftlet::tools
