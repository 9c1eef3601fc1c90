// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Field of view of a vehicle's mutual-localization sensor.
struct NeighborView {
  struct Cone {
    Vector3 axis_body = Vector3::UnitX();  ///< unit length
    double cos_half_angle = 0.0;
  };
  std::vector<Cone> cones;  ///< fields of view of the cameras; none: omnidirectional between the elevations
  double sin_elevation_min = -1.0, sin_elevation_max = 1.0;
  double range_min_m = 0.0, range_max_m = std::numeric_limits<double>::infinity();

  /// True if the position is in the field of view and in range, regardless of occlusion.
  bool contains(const Vector3& p_body_m) const { return p_body_m.norm() <= range_max_m && looks_at(p_body_m); }

  /// True if the position is in the field of view, at any range above range_min_m.
  bool looks_at(const Vector3& p_body_m) const {
    const double range_m = p_body_m.norm();
    if (range_m < range_min_m || range_m <= 0.0) return false;
    if (cones.empty()) {
      return p_body_m.z() >= sin_elevation_min * range_m && p_body_m.z() <= sin_elevation_max * range_m;
    }
    return std::any_of(cones.begin(), cones.end(),
                       [&](const Cone& cone) { return cone.axis_body.dot(p_body_m) >= cone.cos_half_angle * range_m; });
  }
};

}  // namespace swiftlet
