// SPDX-License-Identifier: BSD-3-Clause
// Memory over a long run: what a run needs it has after its first seconds.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/recorder_types.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

// Everything with memory: a small LiDAR, all other sensors, an estimator, gusts, contacts, a mission.
constexpr const char* kScenario = R"(
duration_s: 10000
world: {type: hall}
wind: {mean_mps: [0.5, 0, 0], gusts: true}
metrics: {stop_when_done: false}
vehicles:
  - name: uav1
    start: {position_m: [-5, -2, 2]}
    sensors:
      - {type: lidar, pattern: {type: uniform, columns: 64, rows: 8}}
      - {type: imu}
      - {type: gnss, random_outages_per_min: 5}
      - {type: altimeter}
      - {type: compass}
      - {type: neighbors}
    agent: {localization: {type: ins}, guidance: {type: waypoints, loop: true, waypoints_m: [[-5, 2, 2], [-5, -2, 2]]}}
  - name: uav2
    model: f450
    start: {position_m: [5, 0, 3]}
    sensors: [{type: imu}, {type: odometry}, {type: neighbors}]
    agent: {localization: {type: odometry}, guidance: {type: hover}}
  - name: uav3
    model: f330
    start: {position_m: [5, 3, 0.5], flying: false}
    agent: {localization: {type: ground_truth}, guidance: {type: takeoff_land, altitude_m: 0.5, hover_s: 1}}
)";

Scenario small_scenario() {
  const TemporaryDirectory folder;
  write_file(folder.path() / "scenario.yaml", kScenario);
  return load_scenario(folder.path() / "scenario.yaml");
}

void fly_until(Simulation& simulation, double t_s) {
  while (simulation.now() < from_seconds(t_s)) simulation.tick();
}

/// Memory of the program that is in use by the operating system's account [bytes].
long resident_bytes() {
  long total = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

TEST(LongRun, MemoryStaysConstantOverTwoMinutes) {
  Simulation simulation(small_scenario(), 1);
  fly_until(simulation, 10.0);
  const std::int64_t live = test::num_live_bytes();
  [[maybe_unused]] const long resident = resident_bytes();
  fly_until(simulation, 120.0);
  EXPECT_EQ(test::num_live_bytes() - live, 0) << "bytes more";
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // these keep freed memory
  EXPECT_LT(resident_bytes() - resident, 1'000'000) << "bytes more, not all by operator new";
#endif
}

std::int64_t bytes_in(const std::filesystem::path& folder) {
  std::int64_t bytes = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) bytes += static_cast<std::int64_t>(entry.file_size());
  }
  return bytes;
}

// A recorder may keep an index of the chunks that it wrote, and nothing else: the data itself goes to the disk. A
// buffer grows now and then; what is kept for good grows in every span of time.
TEST(LongRun, RecordersKeepAtMostAnIndex) {
  constexpr double kSpan_s = 10.0;
  for (const char* type : recorders_of_any_run()) {
    Scenario scenario = small_scenario();
    scenario.recorders.emplace_back(recorder_module_types(), type);
    const TemporaryDirectory folder;
    Simulation simulation(scenario, 1);
    simulation.attach_recorders(folder.path());
    std::int64_t least_growth = std::numeric_limits<std::int64_t>::max();
    for (int span = 0; span < 4; ++span) {
      const std::int64_t before = test::num_live_bytes();
      fly_until(simulation, (span + 1) * kSpan_s);
      least_growth = std::min(least_growth, test::num_live_bytes() - before);
    }
    EXPECT_LT(least_growth, 10'000) << "bytes more in every " << kSpan_s << " s with the recorder " << type
                                    << ", which has written " << bytes_in(folder.path());
  }
}

}  // namespace
}  // namespace swiftlet::sim
