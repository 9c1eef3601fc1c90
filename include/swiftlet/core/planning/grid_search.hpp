// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "swiftlet/core/planning/free_space.hpp"

namespace swiftlet {

enum class PathStatus { kFound, kStartNotFree, kGoalNotFree, kNoPath, kBudgetSpent };

/// A path, or the reason why there is none.
struct PathResult {
  PathStatus status = PathStatus::kNoPath;
  std::vector<Vector3> corners_world_m;  ///< from the start to the goal; empty when there is none
};

/// Corners of a short free path: A* over the 26 neighbors of a cell, then removal of unnecessary corners. A pure
/// function: equal spaces give equal paths.
/// @param max_expansions  limit of expanded cells
PathResult find_path(const FreeSpaceView& space, const Vector3& start_world_m, const Vector3& goal_world_m,
                     std::size_t max_expansions = std::numeric_limits<std::size_t>::max());

}  // namespace swiftlet
