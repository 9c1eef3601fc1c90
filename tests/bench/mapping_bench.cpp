// SPDX-License-Identifier: BSD-3-Clause
// Occupancy mapping at 0.1 m with rays of 20 m, compared with OctoMap's library in the same program: scans of 24 064
// returns at 20 m, and those of an OS0-128 thinned by four that flies through a forest. Then distances to obstacles
// after every scan, and paths through the map. One thread, processor time.
#include <benchmark/benchmark.h>
#include <octomap/octomap.h>
#include <omp.h>

#include <cmath>
#include <vector>

#include "core/planning/guiding_viewpoint.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/planning/clear_path.hpp"
#include "tests/bench/processor_time.hpp"
#include "tests/support/flown_scans.hpp"

namespace swiftlet {
namespace {

using Rays = std::vector<OccupancyMap::Ray>;

constexpr int kScans = 40;        // 4 s of flight
constexpr int kLibraryScans = 5;  // the library takes seconds per scan
constexpr double kRangeMax_m = 20.0;

/// A sensor that flies at 2 m/s; no return is nearer than 20 m.
const std::vector<Rays>& far_scans() {
  static const std::vector<Rays> scans = [] {
    std::vector<Rays> made;
    for (int s = 0; s < kScans; ++s) {
      const Eigen::Vector3f origin(0.05F + 0.2F * static_cast<float>(s), 0.03F, 1.5F);
      Rays& rays = made.emplace_back();
      for (int row = 0; row < 94; ++row) {
        for (int column = 0; column < 256; ++column) {
          const double elevation = (-45.0 + 90.0 * row / 93.0) * M_PI / 180.0, azimuth = 2.0 * M_PI * column / 256.0;
          const Vector3 direction(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                  std::sin(elevation));
          rays.push_back({origin, origin + 19.99F * direction.cast<float>(), true});
        }
      }
    }
    return made;
  }();
  return scans;
}

const std::vector<Rays>& forest_scans() {
  static const std::vector<Rays> scans = [] {
    std::vector<Rays> made;
    for (const testing::FlownScan& flown : testing::fly_scans("forest.yaml", kScans)) {
      CloudRegistrar registrar(0.3);
      StateEstimate estimate;
      estimate.valid = true;
      estimate.T_local_body = flown.T_world_body;
      registrar.push(estimate);
      LocalCloud cloud;
      registrar.make(flown.scan, cloud);
      const Eigen::Vector3f origin = cloud.T_local_lidar.front().translation().cast<float>();
      Rays& rays = made.emplace_back();
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        if (static_cast<int>(cloud.beam[i]) % flown.scan->cols() % 4 == 0) {
          rays.push_back({origin, cloud.points_local_m[i], true});
        }
      }
    }
    return made;
  }();
  return scans;
}

void insertion(benchmark::State& state, const std::vector<Rays>& scans) {
  double first_s = 0.0, sum_s = 0.0, most_s = 0.0;
  std::size_t cells = 0;
  for (auto _ : state) {
    const auto map = make_occupancy_map({});
    sum_s = most_s = 0.0;
    for (int i = 0; i < kScans; ++i) {
      const double took_s = time_of_s([&] { map->insert(scans[static_cast<std::size_t>(i)], i); });
      if (i == 0) {
        first_s = took_s;
        continue;
      }
      sum_s += took_s;
      most_s = std::max(most_s, took_s);
    }
    state.SetIterationTime(sum_s / (kScans - 1));
    cells = map->num_blocks();
  }
  state.counters["rays"] = static_cast<double>(scans.front().size());
  state.counters["first_ms"] = 1e3 * first_s;
  state.counters["most_ms"] = 1e3 * most_s;
  state.counters["blocks"] = static_cast<double>(cells);
}

void octomap_insertion(benchmark::State& state, const std::vector<Rays>& scans) {
  omp_set_num_threads(1);
  for (auto _ : state) {
    octomap::OcTree tree(0.1);
    double sum_s = 0.0;
    for (int i = 0; i < kLibraryScans; ++i) {
      octomap::Pointcloud cloud;
      const Rays& rays = scans[static_cast<std::size_t>(i)];
      for (const auto& ray : rays) cloud.push_back(ray.end_local_m.x(), ray.end_local_m.y(), ray.end_local_m.z());
      const Eigen::Vector3f& o = rays.front().origin_local_m;
      const double took_s = time_of_s([&] { tree.insertPointCloud(cloud, {o.x(), o.y(), o.z()}, kRangeMax_m); });
      if (i > 0) sum_s += took_s;
    }
    state.SetIterationTime(sum_s / (kLibraryScans - 1));
  }
}

// Distances of all cells of a box around the vehicle, after every scan. A planner queries those near its paths.
void distances(benchmark::State& state, const Cell& half_blocks) {
  const std::vector<Rays>& scans = forest_scans();
  for (auto _ : state) {
    const auto map = make_occupancy_map({});
    double sum_s = 0.0, sum_m = 0.0;
    for (int i = 0; i < kScans; ++i) {
      const Rays& rays = scans[static_cast<std::size_t>(i)];
      map->insert(rays, i);
      const Vector3 p_m = rays.front().origin_local_m.cast<double>();
      const double took_s = time_of_s([&] {
        // A query of one cell computes its whole block.
        for (int z = -half_blocks.z(); z < half_blocks.z(); ++z) {
          for (int y = -half_blocks.y(); y < half_blocks.y(); ++y) {
            for (int x = -half_blocks.x(); x < half_blocks.x(); ++x) {
              sum_m += map->clearance_m(p_m + 0.8 * Vector3(x, y, z), 1.5);
            }
          }
        }
      });
      if (i > 0) sum_s += took_s;
    }
    benchmark::DoNotOptimize(sum_m);
    state.SetIterationTime(sum_s / (kScans - 1));
  }
}

// A path of 12 m through the forest from the vehicle's position.
void path(benchmark::State& state, bool distances_are_known) {
  const std::vector<Rays>& scans = forest_scans();
  ClearPathConfig config;
  config.unknown_is_free = true;
  std::size_t expansions = 0, found = 0;
  const auto map = make_occupancy_map({});
  for (int i = 0; i < kScans; ++i) map->insert(scans[static_cast<std::size_t>(i)], i);
  const Vector3 start_m = scans.back().front().origin_local_m.cast<double>();
  int scan = kScans;
  for (auto _ : state) {
    if (!distances_are_known) map->insert(scans[static_cast<std::size_t>(scan % kScans)], scan);
    ++scan;
    const double took_s = time_of_s([&] {
      const ClearPath path = find_clear_path(*map, config, start_m, start_m + Vector3(10.0, -6.0, -1.0));
      expansions = path.expansions;
      found = path.corners_local_m.size();
    });
    state.SetIterationTime(took_s);
  }
  state.counters["expansions"] = static_cast<double>(expansions);
  state.counters["corners"] = static_cast<double>(found);
}

// Search for a viewpoint of a path of 4 m, after every scan, so that distances are computed anew.
void viewpoint(benchmark::State& state, ViewpointRules::Sight sight) {
  const std::vector<Rays>& scans = forest_scans();
  ViewpointRules rules;
  rules.sight = sight;
  rules.unknown_is_free = true;
  const auto map = make_occupancy_map({});
  for (int i = 0; i < kScans; ++i) map->insert(scans[static_cast<std::size_t>(i)], i);
  const Vector3 watcher_m = scans.back().front().origin_local_m.cast<double>();
  std::vector<Vector3> path_m;
  for (int i = 0; i < 9; ++i) path_m.push_back(watcher_m + Vector3(2.0 + 0.5 * i, 2.0, 0.0));
  int scan = kScans;
  std::size_t found = 0;
  for (auto _ : state) {
    map->insert(scans[static_cast<std::size_t>(scan % kScans)], scan);
    ++scan;
    state.SetIterationTime(
        time_of_s([&] { found = find_guiding_viewpoints(*map, watcher_m, path_m, rules).best_first.size(); }));
  }
  state.counters["places"] = static_cast<double>(found);
}

BENCHMARK_CAPTURE(insertion, far_24064_returns, far_scans())
    ->UseManualTime()
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(octomap_insertion, far_24064_returns, far_scans())
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(insertion, forest_os0, forest_scans())->UseManualTime()->Iterations(3)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(octomap_insertion, forest_os0, forest_scans())
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(distances, of_30_m_30_m_6_4_m, Cell(19, 19, 4))
    ->UseManualTime()
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(distances, of_10_m_10_m_3_2_m, Cell(6, 6, 2))
    ->UseManualTime()
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(path, after_a_scan, false)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(path, again, true)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(viewpoint, in_space, ViewpointRules::Sight::kInSpace)
    ->UseManualTime()
    ->Iterations(20)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(viewpoint, at_waypoint, ViewpointRules::Sight::kAtWaypoint)
    ->UseManualTime()
    ->Iterations(20)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace swiftlet
