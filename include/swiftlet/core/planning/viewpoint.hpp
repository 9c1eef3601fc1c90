// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"
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

}  // namespace swiftlet
