// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::tools {

/// What the least distance of vehicles that fly by rule-based Lloyd depends on.
struct RblConditions {
  double encumbrance_m = 0.5;
  double margin_m = 0.1;
  double sigmas = 2.0;  ///< that the vehicles reserve for what they do not know
  double speed_mps = 4.0;
  double acceleration_mps2 = 2.0;
  double reaction_s = 0.3;  ///< with the period of the updates
  double noise = 0.0;       ///< of the range, share of it
  double latency_s = 0.0;
  double rate_hz = 10.0;
  double range_m = 15.0;       ///< of the sensor
  double maneuver_mps2 = 2.0;  ///< how anybody is believed to change its speed between two samples
  bool all_around = true;      ///< no blind sector
  double intruder_mps = 0.0;   ///< of one that flies straight through; 0: nobody does
};

/// Of the scenario's first vehicle that flies by rbl, and of the fastest one that flies by waypoints and arrives in
/// time.
RblConditions conditions_of(const sim::Scenario& scenario);

/// Between the centers of two X500 at one height. What is promised below this is no promise.
inline constexpr double kTouching_m = 0.81;

/// What keeps a distance from being promised.
enum class RblObstacle {
  kNone,    ///< more than `kTouching_m` is promised
  kUnseen,  ///< an intruder may come from where nobody looks
  kLate,    ///< an intruder is known too late, or never told from the others, to be stepped out of the way of
  kNoise,   ///< samples may be farther off than what is reserved for them
};

/// How long it takes to know how fast somebody comes, from its first sample on: as many samples as tell its speed to a
/// quarter, at least two, and another one that may be lost.
double known_after_s(const RblConditions& conditions);

/// The distance between centers that these conditions promise, as docs/rbl.md derives it. Nothing is promised (0) where
/// an intruder need not be seen before it is there.
double predicted_distance_m(const RblConditions& conditions);

/// Why less is promised than keeps two from touching. The first cause of these that alone suffices.
RblObstacle obstacle_of(const RblConditions& conditions);

/// How long a vehicle must know of an intruder to step aside by all of the distance to keep: until it knows its speed,
/// delay, reaction, and the way. With less warning it was not seen in time.
double needed_warning_s(const RblConditions& conditions);

/// How far a vehicle comes in that time from rest: on and on faster, then at its speed.
double way_from_rest_m(double time_s, double speed_mps, double acceleration_mps2);

}  // namespace swiftlet::tools
