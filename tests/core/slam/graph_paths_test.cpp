// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/graph_paths.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

Pose along_x(double x_m) {
  Pose T = Pose::Identity();
  T.translation().x() = x_m;
  return T;
}

PoseGraph chain(int count) {
  PoseGraph graph;
  for (int i = 0; i < count; ++i) {
    graph.add_pose(along_x(2.0 * i));
    if (i > 0) graph.add(RelativeFactor{i - 1, i, along_x(2.0), Matrix6::Identity(), kNoHuber});
  }
  return graph;
}

TEST(ShortestPaths, IgnoreClosuresWithAnOpenDirection) {
  PoseGraph graph = chain(11);
  Matrix6 open = Matrix6::Identity();
  open(1, 1) = 0.0;
  graph.add(RelativeFactor{1, 9, along_x(0.5), open, 1.0});
  EXPECT_DOUBLE_EQ(shortest_path_lengths_m(graph, 10)[1], 18.0);
}

TEST(ShortestPaths, MatchBellmanFord) {
  const Random random(7, "graph_ways");
  for (std::uint32_t trial = 0; trial < 20; ++trial) {
    constexpr int kPoses = 40;
    PoseGraph graph;
    for (int i = 0; i < kPoses; ++i) graph.add_pose(Pose::Identity());
    for (std::uint32_t e = 0; e < 70; ++e) {
      const int a = static_cast<int>(random.uniform(0.0, kPoses, trial, 4 * e));
      const int b = static_cast<int>(random.uniform(0.0, kPoses, trial, 4 * e + 1));
      const bool closure = random.uniform(0.0, 1.0, trial, 4 * e + 2) < 0.1;
      if (a == b) continue;
      graph.add(RelativeFactor{a, b, along_x(random.uniform(0.1, 5.0, trial, 4 * e + 3)), Matrix6::Identity(),
                               closure ? 1.0 : kNoHuber});
    }
    std::vector<double> expected_m(kPoses, std::numeric_limits<double>::infinity());
    expected_m[0] = 0.0;
    for (int pass = 0; pass < kPoses; ++pass) {
      for (const RelativeFactor& factor : graph.relative_factors()) {
        const double length_m = factor.huber == kNoHuber ? factor.T_from_to.translation().norm() : 0.0;
        double& from_m = expected_m[static_cast<std::size_t>(factor.from)];
        double& to_m = expected_m[static_cast<std::size_t>(factor.to)];
        to_m = std::min(to_m, from_m + length_m);
        from_m = std::min(from_m, to_m + length_m);
      }
    }
    const std::vector<double> path_m = shortest_path_lengths_m(graph, 0);
    for (std::size_t i = 0; i < path_m.size(); ++i) {
      if (std::isinf(expected_m[i])) {
        EXPECT_TRUE(std::isinf(path_m[i]));
      } else {
        EXPECT_NEAR(path_m[i], expected_m[i], 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace swiftlet
