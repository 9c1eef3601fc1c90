// SPDX-License-Identifier: BSD-3-Clause
// Track before detect on a flight of 60 s with an OS1-128 or a Mid-360, 10 sweeps a second, through a clearing of a
// forest with two other UAVs. One thread, processor time of a sweep.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "core/detection/hypotheses.hpp"
#include "tests/bench/detection_flight.hpp"
#include "tests/bench/processor_time.hpp"

namespace swiftlet::sim {
namespace {

constexpr int kScans = 600;

LidarConfig mid360() {
  LidarConfig config;
  config.pattern = Module(lidar_pattern_types(), "livox_mid360");
  return config;
}

void track_before_detect(benchmark::State& state, const LidarConfig& lidar) {
  Flight flight(lidar);
  Hypotheses hypotheses(TrackBeforeDetectConfig{});
  std::vector<double> took_s;
  std::vector<Detection> detections;
  for (auto _ : state) {
    const auto cloud = flight.next();
    const double start_s = processor_time_s();
    hypotheses.take(*cloud);
    took_s.push_back(processor_time_s() - start_s);
    state.SetIterationTime(took_s.back());
    hypotheses.append_reported(detections);
  }
  std::sort(took_s.begin(), took_s.end());
  state.counters["median_ms"] = 1e3 * took_s[took_s.size() / 2];
  state.counters["p99_ms"] = 1e3 * took_s[took_s.size() * 99 / 100];
  state.counters["reported"] = static_cast<double>(detections.size());
}
BENCHMARK_CAPTURE(track_before_detect, os1_128, LidarConfig{})
    ->UseManualTime()
    ->Iterations(kScans)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(track_before_detect, mid360, mid360())
    ->UseManualTime()
    ->Iterations(kScans)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace swiftlet::sim
