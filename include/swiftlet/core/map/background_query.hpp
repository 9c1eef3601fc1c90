// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Query interface of the map of the static surroundings, O of algorithm 2 [Vrba 2025, sec. III-F]: the occupied
/// voxels.
class BackgroundQuery {
 public:
  virtual ~BackgroundQuery() = default;
  /// True when the center of a voxel that is at least tentative lies within `radius_m` of the point. False for a point
  /// outside of the map, or one that is not finite.
  virtual bool occupied_within(const Vector3& p_local_m, double radius_m) const = 0;
};

}  // namespace swiftlet
