// SPDX-License-Identifier: BSD-3-Clause
// Search for a closure between two submaps of 8 m of flight around the campus building: the older one from every second
// scan, the newer one from the remaining scans of the same or of the next submap; with a rough guess, and with a nearly
// correct one. One thread, processor time of a search with all its checks.
#include <benchmark/benchmark.h>

#include <array>
#include <string>
#include <vector>

#include "core/slam/graph/closure.hpp"
#include "core/slam/matching/sweep.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "tests/support/flown_scans.hpp"

namespace swiftlet {
namespace {

constexpr double kSubmap_m = 8.0;
constexpr float kVoxel_m = 0.2F;

struct CloudOfSubmap {
  Pose T_world_submap;
  std::array<std::vector<Eigen::Vector3f>, 2> points_m;  // every second scan; the remaining ones
};

std::vector<Eigen::Vector3f> thinned_m(const std::vector<Eigen::Vector3f>& points_m) {
  std::vector<std::uint32_t> kept;
  VoxelThinner().thin(points_m, kVoxel_m, kept);
  std::vector<Eigen::Vector3f> out;
  for (const std::uint32_t i : kept) out.push_back(points_m[i]);
  return out;
}

std::vector<CloudOfSubmap> submaps_of_a_lap() {
  std::vector<CloudOfSubmap> submaps;
  double path_m = 0.0;
  Vector3 last_m = Vector3::Zero();
  int num = 0;
  for (const testing::FlownScan& flown : testing::fly_scans("campus.yaml", 440)) {
    const Vector3 p_m = flown.T_world_body.translation();
    if (num > 0) path_m += (p_m - last_m).norm();
    last_m = p_m;
    if (submaps.empty() || path_m > kSubmap_m) {
      submaps.push_back({flown.T_world_body, {}});
      path_m = 0.0;
    }
    CloudOfSubmap& submap = submaps.back();
    CloudRegistrar registrar(0.3);
    StateEstimate estimate;
    estimate.valid = true;
    estimate.T_local_body = submap.T_world_submap.inverse() * flown.T_world_body;
    registrar.push(estimate);
    LocalCloud cloud;
    registrar.make(flown.scan, cloud);
    std::vector<Eigen::Vector3f>& points_m = submap.points_m[static_cast<std::size_t>(num++ % 2)];
    points_m.insert(points_m.end(), cloud.points_local_m.begin(), cloud.points_local_m.end());
  }
  for (CloudOfSubmap& submap : submaps) {
    for (auto& points_m : submap.points_m) points_m = thinned_m(points_m);
  }
  return submaps;
}

/// @param off_m  assumed error of the guess
void closure(benchmark::State& state, std::size_t ahead, double off_m) {
  static const std::vector<CloudOfSubmap> submaps = submaps_of_a_lap();
  const Pose off = make_pose({0.4, -0.3, 0.1}, rotation_by({0, 0, 0.02}));
  std::size_t i = 0;
  int closed = 0, expanded = 0;
  for (auto _ : state) {
    const CloudOfSubmap &older = submaps[i % submaps.size()], &newer = submaps[(i + ahead) % submaps.size()];
    const Pose T_guess = older.T_world_submap.inverse() * newer.T_world_submap * off;
    const ClosureCandidate candidate{Pose::Identity(), older.points_m[0], nullptr, T_guess, off_m};
    const ClosureResult result = find_closure({&candidate, 1}, newer.points_m[1], {});
    closed += result.closed();
    expanded += static_cast<int>(result.num_expanded);
    ++i;
  }
  state.counters["closed"] = static_cast<double>(closed) / static_cast<double>(i);
  state.counters["expanded"] = static_cast<double>(expanded) / static_cast<double>(i);
}

constexpr double kRoughly_m = 3.0;  // assumed error of a guess after a long loop

BENCHMARK_CAPTURE(closure, same_place, 0, kRoughly_m)->Unit(benchmark::kMillisecond)->Iterations(20);
BENCHMARK_CAPTURE(closure, next_place, 1, kRoughly_m)->Unit(benchmark::kMillisecond)->Iterations(20);
BENCHMARK_CAPTURE(closure, same_place_nearly_right, 0, 0.6)->Unit(benchmark::kMillisecond)->Iterations(20);
BENCHMARK_CAPTURE(closure, next_place_nearly_right, 1, 0.6)->Unit(benchmark::kMillisecond)->Iterations(20);

}  // namespace
}  // namespace swiftlet
