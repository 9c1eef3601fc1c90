// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::sim {

/// An input file that a scenario names.
struct NamedFile {
  std::string key;   ///< "vehicles[0].agent.localization.global.map"
  std::string path;  ///< never empty
};

/// All of them, in the order of their keys in the resolved scenario.
std::vector<NamedFile> named_files(const Scenario& scenario);

/// A place in the world that a vehicle's configuration names.
struct NamedPlace {
  std::string key;  ///< "agent.guidance.waypoints_m[2]"
  Eigen::Vector3d p_world_m;
};

/// Waypoints, goals and perches that the vehicle is meant to reach.
std::vector<NamedPlace> destinations_of(const VehicleConfig& vehicle);

}  // namespace swiftlet::sim
