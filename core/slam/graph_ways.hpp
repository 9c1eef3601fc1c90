// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {

/// How far is it from one pose of a graph to each of the others, along relative factors? Closures have a Huber loss.
/// They join places that were left long ago, and count nothing. A closure that leaves a direction open leads nowhere.
/// So errors of the way between two poses grow with this and no longer with the time between them.
/// By Dijkstra (1959).
///
/// @return by pose [m]; infinite where no factors lead to
std::vector<double> shortest_ways_m(const PoseGraph& graph, int from_pose);

}  // namespace swiftlet
