// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/graph_paths.hpp"

#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "core/slam/symmetric_eigen.hpp"

namespace swiftlet {
namespace {

// [1/m^2, 1/rad^2] Smallest information of a closure in its least certain direction. Larger values take loose closures
// for open ones.
constexpr double kMinInformation = 1.0;

struct GraphEdge {
  int to = 0;
  double length_m = 0.0;
};

/// True when the factor leaves some direction of the relative pose unconstrained.
bool leaves_open(const RelativeFactor& factor) {
  return factor.huber != kNoHuber && symmetric_eigen<6>(factor.information).values(0) < kMinInformation;
}

std::vector<std::vector<GraphEdge>> edges_of(const PoseGraph& graph) {
  std::vector<std::vector<GraphEdge>> edges(static_cast<std::size_t>(graph.num_poses()));
  for (const RelativeFactor& factor : graph.relative_factors()) {
    if (leaves_open(factor)) continue;
    const double length_m = factor.huber == kNoHuber ? factor.T_from_to.translation().norm() : 0.0;
    edges[static_cast<std::size_t>(factor.from)].push_back({factor.to, length_m});
    edges[static_cast<std::size_t>(factor.to)].push_back({factor.from, length_m});
  }
  return edges;
}

}  // namespace

std::vector<double> shortest_path_lengths_m(const PoseGraph& graph, int from_pose) {
  const std::vector<std::vector<GraphEdge>> edges = edges_of(graph);
  std::vector<double> path_length_m(edges.size(), std::numeric_limits<double>::infinity());
  using Reached = std::pair<double, int>;  // path length and pose: ties are broken by the pose
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> front;
  path_length_m[static_cast<std::size_t>(from_pose)] = 0.0;
  front.emplace(0.0, from_pose);
  while (!front.empty()) {
    const auto [so_far_m, pose] = front.top();
    front.pop();
    if (so_far_m > path_length_m[static_cast<std::size_t>(pose)]) continue;
    for (const GraphEdge& edge : edges[static_cast<std::size_t>(pose)]) {
      double& best_m = path_length_m[static_cast<std::size_t>(edge.to)];
      if (so_far_m + edge.length_m >= best_m) continue;
      best_m = so_far_m + edge.length_m;
      front.emplace(best_m, edge.to);
    }
  }
  return path_length_m;
}

}  // namespace swiftlet
