// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "swiftlet/core/map/overlaid_occupancy.hpp"
#include "swiftlet/core/planning/plane_region.hpp"
#include "swiftlet/core/planning/viewpoint.hpp"

/// Viewpoints from which a path is visible [Pritzl 2024, alg. 2].
namespace swiftlet {

struct GuidingViewpoints {
  std::vector<GuidingViewpoint> best_first;  ///< empty: the first waypoint is visible from no safe position
  std::vector<PlaneRegion> visible;          ///< V_i without B, one per waypoint
};

/// End points of rays from a point in its horizontal plane, counter-clockwise: at the first occupied cell, or at the
/// maximum length. The region inside is visible from the point [Pritzl 2024, alg. 2, lines 4 to 8].
Ring visibility_ring(const OccupancyView& map, const Vector3& p_local_m, double ray_max_m, int num_rays);

/// Viewpoints at the observer's height with as many visible waypoints as possible from the first on. They keep clear of
/// obstacles, of the path and of other vehicles. Each is the nearest pole of inaccessibility of the intersection of its
/// connected safe region with the visibility regions.
/// @param path_local_m    at least one waypoint
/// @param before_local_m  path that is flown before, during the observer's flight. Viewpoints keep clear of it, too.
///                        The regions on either side of the path are then separate, because the observer may not
///                        cross it.
/// @param keep_outs       volumes of other vehicles: no viewpoints, but they do not occlude
GuidingViewpoints find_guiding_viewpoints(const OccupancyView& map, const Vector3& watcher_local_m,
                                          std::span<const Vector3> path_local_m, const ViewpointRules& rules,
                                          std::span<const Vector3> before_local_m = {},
                                          std::span<const KeepOut> keep_outs = {});

}  // namespace swiftlet
