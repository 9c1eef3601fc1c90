// SPDX-License-Identifier: BSD-3-Clause
// Local SLAM on the scans of flights, with all steps of a scan: undistortion, thinning, matching, mapping. One thread,
// processor time of the scans after the first second. A point-to-point odometry without IMU, written from its paper, is
// the reference for the error after the best alignment.
#include <benchmark/benchmark.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/slam/matching/grid_matcher.hpp"
#include "core/slam/matching/local_slam.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "tests/support/icp_odometry.hpp"
#include "tests/support/path_error.hpp"

namespace swiftlet {
namespace {

/// Samples and scans of one tick.
struct Sensed {
  std::vector<ImuSample> imu;
  std::vector<std::shared_ptr<const Scan>> scans;
  Vector3 p_world_m = Vector3::Zero();          // position of the body at the end of the tick
  std::vector<Vector3> p_world_lidar_middle_m;  // position of the LiDAR in the middle of each sweep
};

struct Flown {
  Pose T_world_body_start = Pose::Identity();
  double radius_m = 0.0;
  std::vector<Sensed> ticks;
};

constexpr double kFlight_s = 12.0;
/// Scans that are not timed: the first ones are matched again after the start.
const int kStartScans = LocalSlamConfig{}.start_scans + 2;

Flown fly(const std::string& scenario_file, const std::string& lidar) {
  sim::Scenario scenario = sim::load_scenario(std::string(SWIFTLET_SOURCE_DIR) + "/scenarios/" + scenario_file,
                                              {{"recorders", "[]"},
                                               {"snapshots", "[]"},
                                               {"vehicles[0].sensors[0]", "{type: lidar, name: lidar, model: " + lidar +
                                                                              ", mount: {position_m: [0, 0, 0.25]}}"},
                                               {"vehicles[0].agent.localization", "{type: ground_truth}"}});
  scenario.vehicles.resize(1);
  scenario.duration_s = kFlight_s;
  sim::Simulation simulation(sim::validated(scenario), 2);
  Flown flown;
  flown.radius_m = simulation.info().airframes[0]->circumscribed_radius_m();
  simulation.tick();
  flown.T_world_body_start = simulation.view().states[0].T_world_body();
  while (!simulation.finished()) {
    simulation.tick();
    const Observation& o = simulation.view().observations[0];
    Sensed sensed{o.imu, o.scans, simulation.view().states[0].T_world_body().translation(), {}};
    for (const auto& labeled : simulation.view().scans[0]) {
      const std::vector<Pose>& T_world_lidar = labeled->truth.T_world_lidar;
      sensed.p_world_lidar_middle_m.push_back(T_world_lidar[T_world_lidar.size() / 2].translation());
    }
    flown.ticks.push_back(std::move(sensed));
  }
  return flown;
}

void icp_odometry(benchmark::State& state, const std::string& scenario_file, const std::string& lidar) {
  const Flown flown = fly(scenario_file, lidar);
  std::vector<Vector3> p_m, p_true_m;
  for (auto _ : state) {
    support::IcpOdometry odometry(support::SweepTimes::kAsFired);
    for (const Sensed& sensed : flown.ticks) {
      for (std::size_t i = 0; i < sensed.scans.size(); ++i) {
        p_m.push_back(odometry.add(*sensed.scans[i]).translation());
        p_true_m.push_back(sensed.p_world_lidar_middle_m[i]);
      }
    }
  }
  state.counters["scan_s"] = benchmark::Counter(
      static_cast<double>(p_m.size()), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["error_mm"] = 1e3 * support::absolute_error_m(p_m, p_true_m);
}

void local_slam(benchmark::State& state, const std::string& scenario_file, const std::string& lidar,
                bool grid = false) {
  const Flown flown = fly(scenario_file, lidar);
  std::size_t bytes = 0;
  std::vector<Vector3> p_m, p_true_m;
  for (auto _ : state) {
    state.PauseTiming();
    std::unique_ptr<ScanMatcher> matcher;
    if (grid) matcher = std::make_unique<GridMatcher>(GridMatchingConfig{});
    LocalSlam slam({}, flown.T_world_body_start, flown.radius_m, std::move(matcher));
    int num_scans = 0;
    for (const Sensed& sensed : flown.ticks) {
      for (const ImuSample& sample : sensed.imu) slam.add(sample);
      for (const auto& scan : sensed.scans) {
        const bool timed = ++num_scans > kStartScans;
        if (timed) state.ResumeTiming();
        benchmark::DoNotOptimize(slam.add(scan));
        if (timed) state.PauseTiming();
        p_m.push_back(slam.filter().state().nav.p_m);
        p_true_m.push_back(sensed.p_world_m);
      }
    }
    bytes = slam.matcher().bytes();
    state.counters["scans"] = num_scans - kStartScans;
    state.ResumeTiming();
  }
  state.counters["error_mm"] = 1e3 * support::absolute_error_m(p_m, p_true_m);
  state.counters["map_MB"] = 1e-6 * static_cast<double>(bytes);
  state.counters["scan_s"] = benchmark::Counter(
      state.counters["scans"], benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Matching to probability grids, as in the document.
void grid_slam(benchmark::State& state, const std::string& scenario_file, const std::string& lidar) {
  local_slam(state, scenario_file, lidar, true);
}

BENCHMARK_CAPTURE(local_slam, puck_campus, "campus.yaml", "puck_lite")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(local_slam, os1_campus, "campus.yaml", "os1_128")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(local_slam, os1_forest, "forest.yaml", "os1_128")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(local_slam, mid360_campus, "campus.yaml", "mid360")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(local_slam, mid360_forest, "forest.yaml", "mid360")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(grid_slam, puck_campus, "campus.yaml", "puck_lite")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(grid_slam, os1_campus, "campus.yaml", "os1_128")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(grid_slam, os1_forest, "forest.yaml", "os1_128")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(grid_slam, mid360_campus, "campus.yaml", "mid360")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(grid_slam, mid360_forest, "forest.yaml", "mid360")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(icp_odometry, puck_campus, "campus.yaml", "puck_lite")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(icp_odometry, os1_campus, "campus.yaml", "os1_128")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(icp_odometry, os1_forest, "forest.yaml", "os1_128")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(icp_odometry, mid360_campus, "campus.yaml", "mid360")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(icp_odometry, mid360_forest, "forest.yaml", "mid360")->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace swiftlet
