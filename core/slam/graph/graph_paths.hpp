// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {

/// [m] Path length below which the assumed error of odometry shrinks no further. Smaller values let poses near each
/// other outweigh all closures.
inline constexpr double kMinPathLength_m = 0.05;

/// Length of the shortest path from one pose of a graph to each of the others along relative factors, by Dijkstra
/// (1959). Closures (factors with a Huber loss) join places left long ago and have zero length; closures that leave a
/// direction open are no edges. Errors between two poses grow with this length and no longer with the time between
/// them.
///
/// @return length per pose [m]; infinite where no factors lead
std::vector<double> shortest_path_lengths_m(const PoseGraph& graph, int from_pose);

}  // namespace swiftlet
