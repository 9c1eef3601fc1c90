// SPDX-License-Identifier: BSD-3-Clause
// One update of the 3D rule-based Lloyd algorithm: r 3.5 m, samples every 0.2 m, 15 neighbors, all three centroids;
// then with some 5000 voxels of a forest floor with trunks.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/guidance/flocking/rbl_obstacles.hpp"
#include "core/guidance/flocking/rbl_planner.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

constexpr double kEdge_m = 0.2;

std::vector<Vector3> ring_of_neighbors(int n) {
  std::vector<Vector3> neighbors;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * kPi * i / n;
    neighbors.emplace_back((2.5 + 0.1 * i) * std::cos(angle), (2.5 + 0.1 * i) * std::sin(angle),
                           5.0 + 0.3 * std::sin(5.0 * angle));
  }
  return neighbors;
}

std::vector<Vector3> voxels_around(std::size_t count) {
  std::vector<Vector3> voxels;
  for (int k = 0; k < 40; ++k) {  // trunks of 0.5 m, from near to far
    const double angle = 2.4 * k, distance = 1.6 + 0.06 * k;
    for (int z = -19; z <= 19; ++z) {
      for (int i = 0; i < 16; ++i) {
        const double around = 2.0 * kPi * i / 16;
        const Vector3 p(distance * std::cos(angle) + 0.5 * std::cos(around),
                        distance * std::sin(angle) + 0.5 * std::sin(around), 5.0 + 0.2 * z);
        const Vector3 center = ((p.array() / kEdge_m).floor() + 0.5).matrix() * kEdge_m;
        if ((center - Vector3(0, 0, 5)).norm() < 3.9) voxels.push_back(center);
      }
    }
  }
  std::sort(voxels.begin(), voxels.end(), [](const Vector3& a, const Vector3& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  });
  voxels.erase(std::unique(voxels.begin(), voxels.end()), voxels.end());
  voxels.resize(std::min(voxels.size(), count));
  return voxels;
}

void update(benchmark::State& state, const char* obstacles) {
  RblCellConfig cells;
  RblPlanner planner(cells, {}, false);
  const std::vector<Vector3> neighbors = ring_of_neighbors(15);
  const std::vector<Vector3> voxels = voxels_around(5000);
  ObstacleCutter cutter;
  const std::string mode = obstacles;
  const Vector3 p(0, 0, 5);
  // A destination to the side, as while avoiding, so that the third centroid is needed too.
  for (int i = 0; i < 5; ++i) {
    planner.partition(p, std::vector<Vector3>{{1.3, 0.0, 5.0}, {0.0, 1.3, 5.0}, {0.0, -1.3, 5.0}}, 1.0, 10.0);
    planner.update({20, 1, 5}, 0.1);
  }
  for (auto _ : state) {
    planner.partition(p, neighbors, 1.0, 10.0);
    if (mode == "convex") cutter.cut(planner.cell(), p, voxels, kEdge_m, 0.5, 0.9, planner.cuts());
    benchmark::DoNotOptimize(planner.update({20, 1, 5}, 1e-6));
  }
  state.counters["samples"] = planner.cell().num_samples();
  state.counters["voxels"] = mode.empty() ? 0.0 : static_cast<double>(voxels.size());
}

BENCHMARK_CAPTURE(update, neighbors_15, "")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(update, voxels_convex, "convex")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace swiftlet
