// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::sim {

/// An input file named by a scenario.
struct NamedFile {
  std::string key;   ///< "vehicles[0].agent.localization.global.map"
  std::string path;  ///< never empty
};

/// All input files, in the order of their keys in the resolved scenario.
std::vector<NamedFile> named_files(const Scenario& scenario);

/// A position in the world from a vehicle's configuration.
struct NamedPlace {
  std::string key;  ///< "agent.guidance.waypoints_m[2]"
  Eigen::Vector3d p_world_m;
};

/// Configured waypoints, goals and perches of the vehicle.
std::vector<NamedPlace> destinations_of(const VehicleConfig& vehicle);

}  // namespace swiftlet::sim
