// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/prior_map.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Prior knowledge of a vehicle about the world: points read from files, and points on surfaces. Surfaces are sampled
/// densely enough that every voxel they pass contains a point (except where they only cut a corner). Null when nothing
/// is configured.
/// Throws InputError.
/// @param world  the scenario's world, for `world: true`
std::shared_ptr<const PriorMap> make_prior_map(const PriorConfig& config, double voxel_m, const Scene& world,
                                               const std::string& key = "prior");

/// Samples points on every triangle, at most `spacing_m` apart.
void append_surface_points(const Scene& scene, double spacing_m, const std::string& key,
                           std::vector<Eigen::Vector3f>& points_world_m);

}  // namespace swiftlet::sim
