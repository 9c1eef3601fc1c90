// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <vector>

#include "core/interception/chase_mpc.hpp"

namespace swiftlet {
namespace {

/// One planning step of 20 intervals, from the plan of 0.05 s ago to the present aim, with or without walls in reach.
void plan(benchmark::State& state) {
  const MotionLimits limits{8.0, 4.0, 60.0, 4.0, 2.0, 60.0, 2.0, 2.0};
  constexpr double kStep_s = 0.1, kPeriod_s = 0.05;
  ChaseMpc mpc({}, limits, 20);
  std::array<ChaseAim, 20> aims;
  PointState self;
  double t_s = 0.0;
  std::vector<double> times_us;
  times_us.reserve(1 << 16);
  for (auto _ : state) {
    // The aim jumps every 4 s and moves on from there.
    t_s += kPeriod_s;
    const int leg = static_cast<int>(t_s / 4.0);
    const Vector3 from(12.0 * (leg % 3 - 1), 10.0 * (leg % 2), 3.0 * (leg % 4)), v_mps(4.0 - leg % 5, 3.0, 0.5);
    for (int k = 0; k < 20; ++k) {
      ChaseAim& aim = aims[static_cast<std::size_t>(k)];
      aim.p_m = from + (t_s - 4.0 * leg + (k + 1) * kStep_s) * v_mps;
      aim.num_walls = static_cast<int>(state.range(0));
      aim.walls[0] = {Vector3::UnitX(), 11.0};
      aim.walls[1] = {-Vector3::UnitZ(), -1.0};
    }
    const auto begin = std::chrono::steady_clock::now();
    mpc.solve(self, aims, kStep_s);
    times_us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
    benchmark::DoNotOptimize(self = mpc.at(kPeriod_s));
  }
  std::sort(times_us.begin(), times_us.end());
  state.counters["median_us"] = times_us[times_us.size() / 2];
  state.counters["p99_us"] = times_us[times_us.size() * 99 / 100];
}
BENCHMARK(plan)->ArgName("walls")->Arg(0)->Arg(2);

}  // namespace
}  // namespace swiftlet
