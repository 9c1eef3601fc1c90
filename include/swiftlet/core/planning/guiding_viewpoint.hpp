// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/map/overlaid_occupancy.hpp"
#include "swiftlet/core/planning/plane_region.hpp"

/// Viewpoints from which a path is visible [Pritzl 2024, alg. 2].
namespace swiftlet {

/// Requirements on a viewpoint. The defaults are those of [Pritzl 2024, tab. I].
struct ViewpointRules {
  int num_rays = 500;        ///< n_samples: rays of the visibility region of a waypoint
  double ray_max_m = 6.0;    ///< d_ray
  double buffer_m = 2.0;     ///< d_buffer: distance from the observed path
  double clearance_m = 0.9;  ///< d_P: distance from obstacles
  double margin_m = 0.15;    ///< radius around a viewpoint with equal visibility; not in the document
  bool unknown_is_free = false;
  bool unseen_start = true;  ///< if the start of the path is visible from nowhere, observe the visible rest

  /// Visibility test of a waypoint. kAtWaypoint: in the plane at its own height [Pritzl 2024, alg. 2, line 6].
  /// kInSpace: along the line from the viewpoint, which is at the observer's height.
  enum class Sight { kAtWaypoint, kInSpace };
  Sight sight = Sight::kInSpace;

  /// Choice of the connected safe region. kClosest: the one nearest to the observer [Pritzl 2024, alg. 2, line 15].
  /// kMaxVisible: all, in order of visible waypoints; for equal counts the nearest first.
  enum class SafeSpace { kClosest, kMaxVisible };
  SafeSpace safe_space = SafeSpace::kMaxVisible;

  void visit(ConfigVisitor& v);
};

/// A viewpoint and the regions from which it was computed.
struct GuidingViewpoint {
  Vector3 p_local_m = Vector3::Zero();
  int first_visible = 0;  ///< index of a waypoint; 0 unless the start of the path is visible from nowhere
  int num_visible = 0;    ///< visible waypoints from the first one on, without a gap
  PlaneRegion safe;       ///< S_closest
  PlaneRegion overlap;    ///< I_all
};

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
