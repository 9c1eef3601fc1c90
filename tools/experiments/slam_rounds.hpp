// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "swiftlet/sim/scenario/scenario.hpp"

/// Rounds of an X500 through worlds, for experiments with SLAM.
namespace swiftlet::tools {

/// A closed path in a world, free of obstacles for every seed.
struct DriftWorld {
  const char* scenario;
  const char* start_m;
  const char* waypoints_m;
  double round_m;
  double agile_mps;
  bool costly;  // many leaves: left out of quick versions
  const char* more_key = "";
  const char* more = "";
};
inline constexpr DriftWorld kDriftWorlds[] = {
    {"campus", "[-12.5, -10, 3]", "[[12.5, -10, 3], [12.5, 10, 4], [-12.5, 10, 4], [-12.5, -10, 3]]", 90.0, 6.0, false},
    {"forest", "[-27, -12, 4]",
     "[[-12, -8, 4], [0, 0, 4], [10, 12, 4], [27, 15, 4], [10, 12, 4], [0, 0, 4], [-12, -8, 4], [-27, -12, 4]]", 126.0,
     4.0, true},
    {"warehouse", "[-17.3, -5.68, 3.6]", "[[17.3, -5.68, 3.6], [17.3, 0, 3.6], [-17.3, 0, 3.6], [-17.3, -5.68, 3.6]]",
     80.5, 5.0, false},
    {"hall", "[-5, -3, 2]", "[[5, -3, 2.5], [5, 3, 2], [-5, 3, 2.5], [-5, -3, 2]]", 32.0, 4.0, false},
    {"field", "[-12, -12, 4]", "[[12, -12, 4], [12, 12, 4.5], [-12, 12, 4], [-12, -12, 4]]", 96.0, 6.0, true,
     "world.num_trees", "60"},
};

struct DriftLidar {
  const char* model;
  const char* label;
  double limit_percent;  // median drift of local SLAM
};
inline constexpr DriftLidar kDriftLidars[] = {
    {"puck_lite", "Puck LITE", 0.6}, {"os1_128", "OS1-128", 0.3}, {"mid360", "Mid-360", 0.3}};

/// @param localization  the vehicle's localization, in the syntax of a scenario
sim::Scenario round_flight(const DriftWorld& world, const DriftLidar& lidar, bool agile, double way_m,
                           std::uint64_t seed, const std::string& localization);

}  // namespace swiftlet::tools
