// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/prior_map.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// What a vehicle knows of the world beforehand: points read from files, and points on surfaces. Surfaces are sampled
/// so densely that every voxel which they pass has one (but for corners that they cut). Null when nothing is asked for.
/// Throws InputError.
/// @param world  the scenario's own, for `world: true`
std::shared_ptr<const PriorMap> make_prior_map(const PriorConfig& config, double voxel_m, const Scene& world,
                                               const std::string& key = "prior");

/// Points on every triangle, at most `spacing_m` apart.
void append_surface_points(const Scene& scene, double spacing_m, const std::string& key,
                           std::vector<Eigen::Vector3f>& points_world_m);

}  // namespace swiftlet::sim
