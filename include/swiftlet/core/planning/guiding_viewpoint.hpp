// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/map/overlaid_occupancy.hpp"
#include "swiftlet/core/planning/plane_region.hpp"

/// From where can a path be watched? [Pritzl 2024, alg. 2]
namespace swiftlet {

/// What is asked of a viewpoint. The defaults are those of [Pritzl 2024, tab. I].
struct ViewpointRules {
  int num_rays = 500;        ///< n_samples: for the visibility region of a waypoint
  double ray_max_m = 6.0;    ///< d_ray
  double buffer_m = 2.0;     ///< d_buffer: from the watched path
  double clearance_m = 0.9;  ///< d_P: from obstacles
  double margin_m = 0.15;    ///< around a viewpoint, from where as much is seen; the document has none
  bool unknown_is_free = false;
  bool unseen_start = true;  ///< a path whose beginning is seen from nowhere is watched from the first waypoint that is

  /// Where a waypoint is looked for. kAtWaypoint: in the plane at its own height [Pritzl 2024, alg. 2, line 6].
  /// kInSpace: along the straight line from the viewpoint, which stays at the watcher's height.
  enum class Sight { kAtWaypoint, kInSpace };
  Sight sight = Sight::kInSpace;

  /// Which connected safe space counts. kClosest: the one nearest to the watcher [Pritzl 2024, alg. 2, line 15].
  /// kMostVisible: all, those first from which more waypoints are seen; among equal ones the nearest.
  enum class SafeSpace { kClosest, kMostVisible };
  SafeSpace safe_space = SafeSpace::kMostVisible;

  void visit(ConfigVisitor& v);
};

/// A place to watch from, and how it was found.
struct GuidingViewpoint {
  Vector3 p_local_m = Vector3::Zero();
  int first_visible = 0;  ///< waypoint; 0 unless the beginning of the path is in sight from nowhere
  int num_visible = 0;    ///< waypoints from that one on without interruption
  PlaneRegion safe;       ///< S_closest
  PlaneRegion overlap;    ///< I_all
};

struct GuidingViewpoints {
  std::vector<GuidingViewpoint> best_first;  ///< none: nowhere safe can the first waypoint be seen
  std::vector<PlaneRegion> visible;          ///< V_i without B, one a waypoint
};

/// Ends of rays from a point in the horizontal plane through it, counter-clockwise: at the first occupied cell, or at
/// the greatest length. What lies between them is seen from the point [Pritzl 2024, alg. 2, lines 4 to 8].
Ring visibility_ring(const OccupancyView& map, const Vector3& p_local_m, double ray_max_m, int num_rays);

/// Places at the watcher's height that see as many waypoints as possible from the first on. They keep clear of
/// obstacles, of the path and of other vehicles. Each is the nearest pole of inaccessibility of what its connected safe
/// space has in common with them.
/// @param path_local_m    at least one waypoint
/// @param before_local_m  what is flown before that path, while the watcher flies. Its places keep clear of that, too.
///                        The space on either side of the path then counts by itself, because nobody may cross it.
/// @param keep_outs       where other vehicles are: nobody's place, but they hide nothing
GuidingViewpoints find_guiding_viewpoints(const OccupancyView& map, const Vector3& watcher_local_m,
                                          std::span<const Vector3> path_local_m, const ViewpointRules& rules,
                                          std::span<const Vector3> before_local_m = {},
                                          std::span<const KeepOut> keep_outs = {});

}  // namespace swiftlet
