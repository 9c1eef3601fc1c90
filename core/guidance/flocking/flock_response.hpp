// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/guidance/separation/neighbor_memory.hpp"
#include "swiftlet/core/guidance/flocking.hpp"

namespace swiftlet {

/// Persistence of a path: distance between its ends over its length; 1 for a straight path, near 0 for a closed one.
double path_persistence(std::span<const Vector3> path_local_m);

/// Commanded changes of speed and heading from the retina. Bearings are relative to the heading, positive to the left.
struct VisualResponse {
  double acceleration_mps2 = 0.0;
  double turn_radps = 0.0;
};

/// @param retina  scratch memory of at least 8 pixels; its size is the resolution
VisualResponse visual_response(const MezeyConfig& config, const Vector3& p_local_m, double heading_rad,
                               std::span<const Neighbor> neighbors, std::vector<char>& retina);

}  // namespace swiftlet
