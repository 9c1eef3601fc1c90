// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "swiftlet/core/planning/path_timing.hpp"
#include "swiftlet/sim/dataset/dataset_config.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"

namespace swiftlet::sim {

/// True if the paths of a flight must stay in places enclosed by walls. `indoors: auto` decides this by the world: yes
/// if walls enclose at least 10 % of its ground, as in a hall or a courtyard; a building in a large area encloses less.
bool stays_indoors(const FlightConfig& config, const StaticScene& world);

/// Plans collision-free paths of a team through a static world. The first vehicle flies to random goals. The goals of
/// the others have log-uniform distances from the first vehicle, between partner_min_m and partner_max_m, and most
/// goals are in the line of sight of the first vehicle. Equal arguments give equal paths.
/// @param radii_m  radii of spheres around the vehicles that surfaces must not enter
/// @param attempt  number of the attempt with this seed; each attempt draws other paths
/// @return one path per vehicle, each of at least `duration_s`; nullopt if the attempt found none
std::optional<std::vector<SplineTrajectory>> plan_flight(const FlightConfig& config,
                                                         const std::shared_ptr<const StaticScene>& world,
                                                         const std::vector<double>& radii_m, double duration_s,
                                                         std::uint64_t seed, int attempt);

}  // namespace swiftlet::sim
