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

/// True if flights of this configuration are restricted to interiors. With `indoors: auto` they are when walls enclose
/// a tenth of the ground, as in a hall or a courtyard. A building in a large area encloses less.
bool stays_indoors(const FlightConfig& config, const StaticScene& world);

/// Collision-free paths for a team in a world. The first vehicle flies to random goals. The others mostly choose goals
/// visible to the first one, whose distances cover [partner_min_m, partner_max_m] uniformly in the logarithm. A pure
/// function of its arguments.
/// @param radii_m  radii of the vehicles' safety spheres
/// @return one path per vehicle, each of at least `duration_s`; nullopt when none was found
std::optional<std::vector<SplineTrajectory>> plan_flight(const FlightConfig& config,
                                                         const std::shared_ptr<const StaticScene>& world,
                                                         const std::vector<double>& radii_m, double duration_s,
                                                         std::uint64_t seed, int attempt);

}  // namespace swiftlet::sim
