// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "swiftlet/sim/world/scene.hpp"

/// Parts of buildings, appended to a mesh. Any frame, the same for all arguments.
namespace swiftlet::sim {

/// A rectangular hole in a wall.
struct Opening {
  double center_m = 0.0;  ///< distance along the wall from its start
  double width_m = 1.0;
  double bottom_m = 0.0;  ///< height above the foot of the wall
  double top_m = 2.0;     ///< at or above the wall's height: open to the top
};

/// A straight wall standing on z = `foot_z_m`; `start` and `end` lie in its middle plane. Openings must be sorted and
/// disjoint.
void add_wall(Mesh& mesh, const Eigen::Vector2d& start_m, const Eigen::Vector2d& end_m, double height_m,
              double thickness_m, std::span<const Opening> openings = {}, double foot_z_m = 0.0);

/// Horizontal rectangle facing up.
void add_floor(Mesh& mesh, const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m, double z_m);

}  // namespace swiftlet::sim
