// SPDX-License-Identifier: BSD-3-Clause
// The three stages of the VoFOD detector (Table II: voxels of 0.25 m, rays of 20 m) on a flight of 60 s with an
// OS1-128, 1024 x 128 beams at 10 Hz, through a clearing of a forest with two other UAVs, against the paper's
// algorithms written out plainly (tests/bench/reference_detection.hpp), whose map and detections must be the same.
// One thread, processor time.
#include <benchmark/benchmark.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/detection/vofod_stages.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/world/forest.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "tests/bench/processor_time.hpp"
#include "tests/bench/reference_detection.hpp"
#include "tests/support/sensor_driver.hpp"

namespace swiftlet::sim {
namespace {

constexpr TimeNs kSweep = 100'000'000;
constexpr TimeNs kStep = 2'000'000;
constexpr int kVehicles = 3;
constexpr int kScans = 600;          // 60 s
constexpr int kReferenceScans = 20;  // plain code takes a second for each

VehicleState state_of(int vehicle, TimeNs t) {
  const double s = to_seconds(t);
  const double radius = vehicle == 0 ? 5.0 : 4.0 + 4.0 * vehicle, speed = vehicle == 0 ? 2.0 : 5.0;
  const double phase = speed / radius * s + 2.0 * vehicle;
  VehicleState state;
  state.t = t;
  state.p_world_m = {radius * std::cos(phase), radius * std::sin(phase), 4.0 + vehicle};
  state.v_world_mps = {-speed * std::sin(phase), speed * std::cos(phase), 0.0};
  state.q_world_body =
      Eigen::AngleAxisd(phase + 0.5 * M_PI, Vector3::UnitZ()) * Eigen::AngleAxisd(0.1, Vector3::UnitY());
  return state;
}

/// Sweep after sweep as clouds in the world.
class Flight {
 public:
  Flight() {
    omp_set_num_threads(1);
    static const auto scene = [] {
      ForestConfig forest;
      forest.size_m = {70.0, 70.0};
      forest.surroundings_m = 0.0;
      forest.detail = 0.5;
      forest.keep_clear.clearings.push_back({{0.0, 0.0}, 14.0});
      return std::make_shared<const Scene>(make_forest(forest, 1));
    }();
    static const auto world = std::make_shared<const StaticScene>(*scene);
    SensorSetup setup = sensor_setup("os1", 1, kVehicles, world);
    setup.scene = scene;
    const auto shape = quadrotor_shape();
    setup.vehicle_shapes.assign(kVehicles, shape);
    lidar_ = make_lidar(LidarConfig{}, std::move(setup));
    fly_to(0);
  }

  std::shared_ptr<const LocalCloud> next() {
    observation_.clear();
    while (observation_.scans.empty()) {
      fly_to(now_ + kStep);
      lidar_->measure(now_, history_, observation_);
    }
    auto cloud = std::make_shared<LocalCloud>();
    registrar_.make(observation_.scans.front(), *cloud);
    return cloud;
  }

 private:
  void fly_to(TimeNs t) {
    now_ = t;
    for (int v = 0; v < kVehicles; ++v) history_.push(v, state_of(v, t));
    StateEstimate estimate;
    estimate.t = t;
    estimate.valid = true;
    estimate.T_local_body = state_of(0, t).T_world_body();
    registrar_.push(estimate);
  }

  std::unique_ptr<Sensor> lidar_;
  StateHistory history_{kVehicles, 200};
  CloudRegistrar registrar_{0.6};
  Observation observation_;
  TimeNs now_ = 0;
};

VofodConfig config() {
  VofodConfig config;
  config.map.extent = VoxelMapConfig::Extent::kBounded;  // the reference knows no other
  return config;
}

/// Processor time of one stage over the flight.
struct Timing {
  double sum_s = 0.0, max_s = 0.0;
  int count = 0;
  template <class Stage>
  double measure(Stage&& stage) {
    const double start = processor_time_s();
    stage();
    const double took = processor_time_s() - start;
    sum_s += took;
    max_s = std::max(max_s, took);
    ++count;
    return took;
  }
  void report(benchmark::State& state, const std::string& name) const {
    state.counters[name + "_ms"] = 1e3 * sum_s / count;
    state.counters[name + "_max_ms"] = 1e3 * max_s;
  }
};

void flight_of_60_s(benchmark::State& state) {
  Flight flight;
  VofodStages stages(config());
  std::vector<Detection> detections;
  Timing classification, raycasting, separation;
  std::size_t found = 0;
  for (auto _ : state) {
    const auto cloud = flight.next();
    detections.clear();
    double took = raycasting.measure([&] { stages.cast_rays(*cloud); });
    took += classification.measure([&] { stages.classify(*cloud, detections); });
    const double rest = raycasting.measure([&] { stages.apply_rays(1); });
    took += rest + separation.measure([&] {
      stages.find_separate();
      stages.remove_separate(1);
    });
    raycasting.count -= 1;  // casting and applying are one
    found += detections.size();
    state.SetIterationTime(took);
  }
  classification.report(state, "classification");
  raycasting.report(state, "raycasting");
  separation.report(state, "separation");
  state.counters["detections"] = static_cast<double>(found);
}
BENCHMARK(flight_of_60_s)->UseManualTime()->Iterations(kScans)->Unit(benchmark::kMillisecond);

[[noreturn]] void fail(int scan, const char* what, double ours, double theirs) {
  std::fprintf(stderr, "scan %d: %s differs from the reference: %.9g instead of %.9g\n", scan, what, ours, theirs);
  std::exit(1);
}

/// The beginning of the same flight, plainly, and compared.
void reference_of_the_paper(benchmark::State& state) {
  Flight flight;
  VofodStages stages(config());
  reference::Vofod plain(config());
  std::vector<Detection> ours;
  Timing classification, raycasting, separation, fast;
  double worst_G = 0.0;
  std::size_t found = 0;
  int scan = 0;
  for (auto _ : state) {
    const auto cloud = flight.next();
    ours.clear();
    fast.measure([&] {
      stages.cast_rays(*cloud);
      stages.classify(*cloud, ours);
      stages.apply_rays(1);
      stages.find_separate();
      stages.remove_separate(1);
    });
    std::vector<Detection> theirs;
    double took = classification.measure([&] { theirs = plain.classify(*cloud); });
    took += raycasting.measure([&] { plain.cast_rays(*cloud, 1); });
    took += separation.measure([&] { plain.remove_separate(1); });
    state.SetIterationTime(took);

    if (ours.size() != theirs.size()) {
      fail(scan, "number of detections", static_cast<double>(ours.size()), static_cast<double>(theirs.size()));
    }
    for (std::size_t i = 0; i < ours.size(); ++i) {
      const double off_m = (ours[i].position_m - theirs[i].position_m).norm();
      if (off_m > 1e-4) fail(scan, "position of a detection", off_m, 0.0);
    }
    for (std::ptrdiff_t i = 0; i < stages.map().grid().num_cells(); ++i) {
      const double G = plain.map.G[plain.map.index(stages.map().grid().cell(i))];
      worst_G = std::max(worst_G, std::abs(G - stages.map().value(i)));
      if (std::abs(G - stages.map().value(i)) > 0.1) fail(scan, "value of a voxel", stages.map().value(i), G);
    }
    found += ours.size();
    ++scan;
  }
  classification.report(state, "classification");
  raycasting.report(state, "raycasting");
  separation.report(state, "separation");
  state.counters["ours_ms"] = 1e3 * fast.sum_s / fast.count;
  state.counters["worst_G"] = worst_G;
  state.counters["detections"] = static_cast<double>(found);
}
BENCHMARK(reference_of_the_paper)->UseManualTime()->Iterations(kReferenceScans)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace swiftlet::sim
