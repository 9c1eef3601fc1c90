// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::tools {

/// Conditions that determine the least distance of vehicles on rule-based Lloyd.
struct RblConditions {
  double encumbrance_m = 0.5;
  double margin_m = 0.1;
  double sigmas = 2.0;  ///< standard deviations reserved for the uncertainty of neighbors
  double speed_mps = 4.0;
  double acceleration_mps2 = 2.0;
  double reaction_s = 0.3;  ///< including the update period
  double noise = 0.0;       ///< relative standard deviation of the range
  double latency_s = 0.0;
  double rate_hz = 10.0;
  double range_m = 15.0;       ///< sensor range
  double maneuver_mps2 = 2.0;  ///< assumed acceleration of neighbors, standard deviation
  bool all_around = true;      ///< no blind sector
  double intruder_mps = 0.0;   ///< speed of a vehicle that flies straight through; 0: none
};

/// Conditions of the scenario's first rbl vehicle. The intruder is the fastest waypoints vehicle that reaches the
/// middle before the scenario ends.
RblConditions conditions_of(const sim::Scenario& scenario);

/// Center distance at which two X500 at equal height touch. A smaller prediction guarantees nothing.
inline constexpr double kTouching_m = 0.81;

/// Why no distance is guaranteed.
enum class RblObstacle {
  kNone,    ///< more than `kTouching_m` is guaranteed
  kUnseen,  ///< an intruder may approach in a blind sector
  kLate,    ///< an intruder is recognized too late to evade, or never
  kNoise,   ///< sample errors may exceed the reserve
};

/// Time from an intruder's first sample until its speed is known to 25 %: enough samples for that, at least two, plus
/// one that may be lost.
double known_after_s(const RblConditions& conditions);

/// Guaranteed distance between centers, as docs/rbl.md derives it; 0 where an intruder may approach unseen.
double predicted_distance_m(const RblConditions& conditions);

/// First cause that alone lowers the guaranteed distance to kTouching_m or less.
RblObstacle obstacle_of(const RblConditions& conditions);

/// Time that a vehicle needs, from an intruder's first sample, to evade by the full distance to keep: speed estimation,
/// delay, reaction and displacement. A shorter warning is too late.
double needed_warning_s(const RblConditions& conditions);

/// Distance covered from rest: constant acceleration up to its speed, then constant speed.
double way_from_rest_m(double time_s, double speed_mps, double acceleration_mps2);

}  // namespace swiftlet::tools
