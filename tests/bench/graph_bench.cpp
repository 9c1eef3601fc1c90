// SPDX-License-Identifier: BSD-3-Clause
// Optimization of pose graphs after a closure: a trajectory that drifted, with submaps of ten keyframes that overlap by
// half, and closures at revisited places.
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "core/slam/graph/block_cholesky.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {
namespace {

constexpr int kPerLap = 250;

Pose truth_at(int i) {
  const double a = 2.0 * M_PI * i / kPerLap;
  return make_pose({30.0 * std::cos(a), 20.0 * std::sin(a), 2.0 + 0.5 * std::sin(3.0 * a)}, rotation_by({0, 0, a}));
}

/// Drift of a keyframe: slow, in every direction.
Pose drifted(int i) {
  const double s = 1e-3 * i;
  const Pose off = make_pose({0.3 * std::sin(s), 0.2 * s, 0.1 * std::sin(2.0 * s)}, rotation_by({0, 0, 0.01 * s}));
  return off * truth_at(i);
}

void add_closures(PoseGraph& graph, int num, int every) {
  const Matrix6 information = 1e4 * Matrix6::Identity();
  for (int i = kPerLap; i < num; i += every) {
    graph.add(RelativeFactor{i - kPerLap, i, truth_at(i - kPerLap).inverse() * truth_at(i), information, 10.0});
  }
}

/// Each node is linked to two submaps and to the next node.
PoseGraph graph_of_nodes(int num) {
  PoseGraph graph;
  const Matrix6 information = 1e6 * Matrix6::Identity();
  for (int i = 0; i < num; ++i) graph.add_pose(drifted(i));
  graph.add(PriorFactor{0, drifted(0), 1e8 * Matrix6::Identity()});
  for (int i = 1; i < num; ++i) graph.add(RelativeFactor{i - 1, i, drifted(i - 1).inverse() * drifted(i), information});
  for (int first = 0; first + 10 <= num; first += 5) {
    const int submap = graph.add_pose(drifted(first));
    for (int i = first; i < first + 10; ++i) {
      graph.add(RelativeFactor{submap, i, drifted(first).inverse() * drifted(i), information});
    }
  }
  add_closures(graph, num, 25);
  return graph;
}

/// A chain of submaps only.
PoseGraph graph_of_submaps(int num) {
  PoseGraph graph;
  for (int i = 0; i < num; ++i) graph.add_pose(drifted(i));
  graph.add(PriorFactor{0, drifted(0), 1e8 * Matrix6::Identity()});
  for (int i = 1; i < num; ++i) {
    graph.add(RelativeFactor{i - 1, i, drifted(i - 1).inverse() * drifted(i), 1e6 * Matrix6::Identity()});
  }
  add_closures(graph, num, 5);
  return graph;
}

void optimize(benchmark::State& state, const PoseGraph& drifted_graph) {
  GraphSolverConfig config;
  config.step_min = 1e-4;
  GraphReport report;
  GraphWorkspace workspace;  // a flight reuses it in every optimization
  for (auto _ : state) {
    state.PauseTiming();
    PoseGraph graph = drifted_graph;
    state.ResumeTiming();
    report = graph.optimize(config, workspace);
  }
  state.counters["iterations"] = report.num_iterations;
  state.counters["factors"] = static_cast<double>(drifted_graph.relative_factors().size());
  state.counters["cost_share"] = report.cost_after / report.cost_before;
}

void submaps(benchmark::State& state) { optimize(state, graph_of_submaps(static_cast<int>(state.range(0)))); }
void nodes(benchmark::State& state) { optimize(state, graph_of_nodes(static_cast<int>(state.range(0)))); }

BENCHMARK(submaps)->Arg(500)->Unit(benchmark::kMillisecond);
BENCHMARK(nodes)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace swiftlet
