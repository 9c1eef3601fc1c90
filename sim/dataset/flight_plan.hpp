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

/// Do flights of this configuration stay inside walls? With `indoors: auto` they do when walls enclose a tenth of the
/// ground, as those of a hall or of a courtyard. A building in a large place encloses less.
bool stays_indoors(const FlightConfig& config, const StaticScene& world);

/// Paths for a team through a world, free of collisions with it and with each other. The first vehicle goes from goal
/// to goal at random. The other vehicles choose goals mostly where the first can see them. Their distances from it
/// cover [partner_min_m, partner_max_m] evenly over the logarithm. A pure function of its arguments.
/// @param radii_m  of the spheres around the vehicles
/// @return one path a vehicle, each of at least `duration_s`; nullopt when none was found
std::optional<std::vector<SplineTrajectory>> plan_flight(const FlightConfig& config,
                                                         const std::shared_ptr<const StaticScene>& world,
                                                         const std::vector<double>& radii_m, double duration_s,
                                                         std::uint64_t seed, int attempt);

}  // namespace swiftlet::sim
