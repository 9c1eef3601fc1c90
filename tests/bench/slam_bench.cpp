// SPDX-License-Identifier: BSD-3-Clause
// Local SLAM on the scans of flights, with all that a scan takes: un-distortion, thinning, matching, mapping. One
// thread, processor time of the scans after the first second.
#include <benchmark/benchmark.h>

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/slam/local_slam.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet {
namespace {

/// What a vehicle sensed in one tick.
struct Sensed {
  std::vector<ImuSample> imu;
  std::vector<std::shared_ptr<const Scan>> scans;
};

struct Flown {
  Pose T_world_body_start = Pose::Identity();
  double radius_m = 0.0;
  std::vector<Sensed> ticks;
};

constexpr double kFlight_s = 12.0;
constexpr int kStartScans = 12;

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
    flown.ticks.push_back({o.imu, o.scans});
  }
  return flown;
}

void local_slam(benchmark::State& state, const std::string& scenario_file, const std::string& lidar) {
  const Flown flown = fly(scenario_file, lidar);
  std::size_t bytes = 0;
  for (auto _ : state) {
    state.PauseTiming();
    LocalSlam slam({}, flown.T_world_body_start, flown.radius_m);
    int num_scans = 0;
    for (const Sensed& sensed : flown.ticks) {
      for (const ImuSample& sample : sensed.imu) slam.add(sample);
      for (const auto& scan : sensed.scans) {
        const bool timed = ++num_scans > kStartScans;
        if (timed) state.ResumeTiming();
        benchmark::DoNotOptimize(slam.add(scan));
        if (timed) state.PauseTiming();
      }
    }
    bytes = slam.map().bytes();
    state.counters["scans"] = num_scans - kStartScans;
    state.ResumeTiming();
  }
  state.counters["map_MB"] = 1e-6 * static_cast<double>(bytes);
  state.counters["scan_s"] = benchmark::Counter(
      state.counters["scans"], benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

BENCHMARK_CAPTURE(local_slam, puck_campus, "campus.yaml", "puck_lite")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(local_slam, os1_campus, "campus.yaml", "os1_128")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(local_slam, os1_forest, "forest.yaml", "os1_128")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(local_slam, mid360_campus, "campus.yaml", "mid360")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(local_slam, mid360_forest, "forest.yaml", "mid360")->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace swiftlet
