// SPDX-License-Identifier: BSD-3-Clause
// Cost of recording: one tick with a scan of an OS1-128 (128 x 1024) of which 80 % return, in each format, and one tick
// without scans. Files go to the directory for temporary files.
#include <benchmark/benchmark.h>

#include <stdexcept>

#include "swiftlet/sim/registry/recorders.hpp"
#include "tests/support/synthetic_run.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

void record_scan(benchmark::State& state, const char* type) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  const auto scan = run.make_scan("os1", run.make_beams(128, 1024), 0, true);
  const auto recorder = make_recorder(Module(recorder_module_types(), type));
  recorder->begin(run.info());
  const std::vector<std::shared_ptr<const LabeledScan>> scans[2] = {{scan}, {}};
  TickView tick = run.tick(0);
  tick.scans = scans;
  for (auto _ : state) {
    tick.t += SyntheticRun::kTick;
    recorder->write(tick);
    // Files per scan would fill the disk: a benchmark of hundreds of scans deletes them.
    state.PauseTiming();
    for (const auto& entry : std::filesystem::recursive_directory_iterator(directory.path())) {
      if (entry.path().extension() == ".pcd" || entry.path().extension() == ".ply")
        std::filesystem::remove(entry.path());
    }
    state.ResumeTiming();
  }
  recorder->finish();
  state.SetItemsProcessed(state.iterations() * scan->scan.size());
}

void record_tick(benchmark::State& state, const char* type) {
  const TemporaryDirectory directory;
  SyntheticRun run(directory.path());
  const auto recorder = make_recorder(Module(recorder_module_types(), type));
  recorder->begin(run.info());
  TickView tick = run.tick(1);
  for (auto _ : state) {
    tick.t += SyntheticRun::kTick;
    recorder->write(tick);
  }
  recorder->finish();
}

BENCHMARK_CAPTURE(record_scan, pcd, "pcd")->Unit(benchmark::kMillisecond)->Iterations(100);
BENCHMARK_CAPTURE(record_scan, ply, "ply")->Unit(benchmark::kMillisecond)->Iterations(100);
BENCHMARK_CAPTURE(record_scan, mcap, "mcap")->Unit(benchmark::kMillisecond)->Iterations(30);
BENCHMARK_CAPTURE(record_scan, rosbag, "rosbag")->Unit(benchmark::kMillisecond)->Iterations(30);
BENCHMARK_CAPTURE(record_tick, tum, "tum")->Unit(benchmark::kMicrosecond)->Iterations(10000);
BENCHMARK_CAPTURE(record_tick, csv, "csv")->Unit(benchmark::kMicrosecond)->Iterations(10000);
BENCHMARK_CAPTURE(record_tick, mcap, "mcap")->Unit(benchmark::kMicrosecond)->Iterations(10000);

}  // namespace
}  // namespace swiftlet::sim
