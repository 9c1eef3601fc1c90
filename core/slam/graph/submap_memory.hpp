// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>

#include "core/slam/graph/trajectory_graph.hpp"

namespace swiftlet {

/// Keeps only the points of the newest submap that the submaps of closed_with lack, if these cover enough of it.
void forget_covered_points(std::span<const OlderSubmap> closed_with, const GlobalSlamConfig& config,
                           TrajectoryGraph& trajectory);

/// An older submap that takes over the cells of a dropped one.
struct SubmapHeir {
  int submap = 0;  ///< number
  Pose T_heir_newest = Pose::Identity();
};

/// Nearest older submap if the newest one can be dropped: visits_kept others began there and cover its points. A submap
/// with a better closure than its predecessor's stays, because it closes a loop.
std::optional<SubmapHeir> heir_of_newest(std::span<const OlderSubmap> closed_with, const GlobalSlamConfig& config,
                                         const TrajectoryGraph& trajectory);

}  // namespace swiftlet
