// SPDX-License-Identifier: BSD-3-Clause
// The three stages of the VoFOD detector (Table II: voxels of 0.25 m, rays of 20 m) on a flight of 60 s with an
// OS1-128, 1024 x 128 beams at 10 Hz, through a clearing of a forest with two other UAVs, compared with the paper's
// algorithms in plain code (tests/bench/reference_detection.hpp), whose map and detections must be equal. One thread,
// processor time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/detection/vofod_stages.hpp"
#include "tests/bench/detection_flight.hpp"
#include "tests/bench/processor_time.hpp"
#include "tests/bench/reference_detection.hpp"

namespace swiftlet::sim {
namespace {

constexpr int kScans = 600;          // 60 s
constexpr int kReferenceScans = 20;  // plain code takes a second per scan

VofodConfig config() {
  VofodConfig config;
  config.map.extent = VoxelMapConfig::Extent::kBounded;  // the only extent of the reference
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
    raycasting.count -= 1;  // casting and applying count as one
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

/// The first scans of the same flight in plain code, with a comparison of the results.
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
