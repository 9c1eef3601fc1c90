// SPDX-License-Identifier: BSD-3-Clause
// A map of submaps after a closure. The submaps are from a Puck LITE around the campus building, 8 m of flight each,
// cells of 0.2 m, rays of 20 m. A hundred of them lie around the building (five overlapping laps), or in a row along a
// street. Then all are moved and rotated, as by a closure. One thread, processor time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/submap_map.hpp"
#include "swiftlet/core/mappers/submap_mapper.hpp"
#include "tests/bench/processor_time.hpp"
#include "tests/support/flown_scans.hpp"

namespace swiftlet {
namespace {

constexpr double kSubmap_m = 8.0;
constexpr int kSubmaps = 100;

struct Seen {
  std::shared_ptr<const SubmapCells> cells;
  Vector3 p_world_m;  // start of the submap
};

/// One lap.
const std::vector<Seen>& lap() {
  static const std::vector<Seen> seen = [] {
    const SubmapMapperConfig config;
    std::vector<Seen> made;
    std::unique_ptr<OccupancyMap> growing;
    Vector3 begun_m = Vector3::Zero(), last_m = Vector3::Zero();
    double path_m = 0.0;
    for (const testing::FlownScan& flown : testing::fly_scans("campus.yaml", 440)) {
      const Vector3 p_m = flown.T_world_body.translation();
      if (growing != nullptr) path_m += (p_m - last_m).norm();
      last_m = p_m;
      if (growing == nullptr || path_m > kSubmap_m) {
        if (growing != nullptr) {
          made.push_back({std::make_shared<const SubmapCells>(config.edge_m, growing->blocks_above(0.7)), begun_m});
        }
        growing = make_occupancy_map(config.growing());
        begun_m = p_m;
        path_m = 0.0;
      }
      CloudRegistrar registrar(0.3);
      StateEstimate estimate;
      estimate.valid = true;
      estimate.T_local_body = flown.T_world_body;
      estimate.T_local_body.translation() -= begun_m;
      registrar.push(estimate);
      LocalCloud cloud;
      registrar.make(flown.scan, cloud);
      const Eigen::Vector3f origin = cloud.T_local_lidar.front().translation().cast<float>();
      std::vector<OccupancyMap::Ray> rays;
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        const int column = static_cast<int>(cloud.beam[i]) % flown.scan->cols();
        if (column % config.every_column == 0) rays.push_back({origin, cloud.points_local_m[i], true});
      }
      growing->insert(rays, flown.scan->stamp);
    }
    return made;
  }();
  return seen;
}

enum class Layout { kLaps, kStreet };

struct Whole {
  std::unique_ptr<SubmapMap> map = make_submap_map(SubmapMapperConfig().whole());
  std::vector<int> pieces;
  std::vector<Pose> poses;
};

void lay_out(Layout layout, Whole& whole) {
  const std::vector<Seen>& seen = lap();
  const int per_lap = static_cast<int>(seen.size());
  for (int i = 0; i < kSubmaps; ++i) {
    const Seen& piece = seen[static_cast<std::size_t>(i % per_lap)];
    // Laps do not coincide exactly.
    const double off_m = 0.07 * (i / per_lap);
    const Vector3 p_m = layout == Layout::kLaps ? Vector3(piece.p_world_m + Vector3(off_m, -off_m, 0.0))
                                                : Vector3(kSubmap_m * i, off_m, 3.0);
    whole.poses.push_back(make_pose(p_m, rotation_by({0, 0, 0.01 * (i / per_lap)})));
    whole.pieces.push_back(whole.map->add(piece.cells, whole.poses.back(), 0, 0));
  }
}

/// Moves submaps like a closure: older ones farther, up to a meter and a degree. The newest stands still.
void close_loop(Whole& whole, int round) {
  const double sign = round % 2 == 0 ? 1.0 : -1.0;
  for (int i = 0; i < kSubmaps; ++i) {
    const double share = sign * (1.0 - static_cast<double>(i) / (kSubmaps - 1));
    Pose& T = whole.poses[static_cast<std::size_t>(i)];
    T = make_pose(share * Vector3(0.8, -0.6, 0.1), rotation_by({0, 0, 0.017 * share})) * T;
    whole.map->move(whole.pieces[static_cast<std::size_t>(i)], T);
  }
}

/// Queries of a planner along 100 m of a path: clearance up to 1.5 m to both sides.
void ask_along(const SubmapMap& map, Layout layout) {
  double sum = 0.0;
  for (int i = 0; i < 500; ++i) {
    const double s = 0.2 * i;
    const Vector3 p_m = layout == Layout::kLaps
                            ? Vector3(-12.5 + std::min(s, 25.0), -10.0 + std::max(0.0, s - 25.0) * 0.3, 3.0)
                            : Vector3(s, 0.0, 3.0);
    sum += map.clearance_m(p_m, 1.5) + (map.state(p_m) == CellState::kFree ? 1.0 : 0.0);
  }
  benchmark::DoNotOptimize(sum);
}

void reanchor(benchmark::State& state, Layout layout) {
  Whole whole;
  lay_out(layout, whole);
  std::vector<Vector3> occupied_m;
  whole.map->append_occupied(occupied_m);
  ask_along(*whole.map, layout);
  double path_s = 0.0, all_s = 0.0;
  std::uint64_t composed = 0;
  int round = 0;
  const std::uint64_t moved = whole.map->num_moved();
  for (auto _ : state) {
    state.SetIterationTime(time_of_s([&] { close_loop(whole, round++); }));
    path_s += time_of_s([&] { ask_along(*whole.map, layout); });
    composed = whole.map->num_composed();
    occupied_m.clear();
    all_s += time_of_s([&] { whole.map->append_occupied(occupied_m); });
    composed = whole.map->num_composed() - composed;
  }
  state.counters["path_ms"] = 1e3 * path_s / round;
  state.counters["all_ms"] = 1e3 * all_s / round;
  state.counters["blocks"] = static_cast<double>(composed);
  state.counters["moved"] = static_cast<double>(whole.map->num_moved() - moved) / round;
}

/// Memory of the pieces, and of the composed map after every cell was queried.
void memory(benchmark::State& state, Layout layout) {
  for (auto _ : state) {
    Whole whole;
    state.SetIterationTime(time_of_s([&] { lay_out(layout, whole); }));
    std::vector<Vector3> occupied_m;
    whole.map->append_occupied(occupied_m);
    double pieces = 0.0;
    for (int i = 0; i < kSubmaps; ++i) {
      pieces += static_cast<double>(lap()[static_cast<std::size_t>(i) % lap().size()].cells->bytes());
    }
    const double km = 1e-3 * kSubmap_m * kSubmaps;
    state.counters["pieces_MB_km"] = 1e-6 * pieces / km;
    state.counters["map_MB_km"] = 1e-6 * static_cast<double>(whole.map->bytes()) / km;
  }
}

/// Removes cells that newer laps contain.
void thin_out(benchmark::State& state) {
  for (auto _ : state) {
    Whole whole;
    lay_out(Layout::kLaps, whole);
    double before = 0.0, after = 0.0;
    const double took_s = time_of_s([&] {
      for (const int piece : whole.pieces) {
        if (whole.map->share_known_by_newer(piece, 32) < 0.9) continue;
        whole.map->replace(piece, whole.map->needed_of(piece));
      }
    });
    for (int i = 0; i < kSubmaps; ++i) {
      before += static_cast<double>(lap()[static_cast<std::size_t>(i) % lap().size()].cells->bytes());
      after += static_cast<double>(whole.map->cells(whole.pieces[static_cast<std::size_t>(i)]).bytes());
    }
    state.SetIterationTime(took_s);
    state.counters["left"] = after / before;
  }
}

BENCHMARK_CAPTURE(reanchor, laps, Layout::kLaps)->UseManualTime()->Iterations(6)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(reanchor, street, Layout::kStreet)->UseManualTime()->Iterations(6)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(memory, laps, Layout::kLaps)->UseManualTime()->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(memory, street, Layout::kStreet)->UseManualTime()->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(thin_out)->UseManualTime()->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace swiftlet
