// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::sim {

/// An input file named by a scenario.
struct NamedFile {
  std::string key;   ///< such as "vehicles[0].agent.localization.global.map"
  std::string path;  ///< never empty
};

/// All input files of a scenario, in the order of its keys.
std::vector<NamedFile> named_files(const Scenario& scenario);

/// A position in the world to which a vehicle is configured to fly.
struct NamedPlace {
  std::string key;  ///< such as "agent.guidance.waypoints_m[2]"
  Eigen::Vector3d p_world_m;
};

/// Waypoints and goals of a vehicle, and perches of a bird.
std::vector<NamedPlace> destinations_of(const VehicleConfig& vehicle);

}  // namespace swiftlet::sim
