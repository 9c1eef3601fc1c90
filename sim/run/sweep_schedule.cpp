// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/sweep_schedule.hpp"

#include <algorithm>
#include <chrono>
#include <string>

#include "sim/parallel/first_exception.hpp"
#include "swiftlet/core/ensure.hpp"

namespace swiftlet::sim {
namespace {

// From here on vehicles without LiDARs are worth several threads, which take so many at a time.
constexpr int kManyVehicles = 16;
constexpr int kVehiclesAtATime = 8;
constexpr int kPartsAtATime = 16;

// An agent whose step takes longer is worth being started before others' sweeps are traced.
constexpr double kLongStep_s = 1e-3;

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// How many a thread takes from the heap: a sweep of a LiDAR is worth a thread of its own, other sensors and controllers
// only where there are many. 0: one thread does all, which costs less than starting others.
int vehicles_at_a_time(const Team& team) {
  if (team.size() < 2) return 0;  // a lone LiDAR is parallel inside
  for (const auto& of_vehicle : team.sensors) {
    for (const auto& sensor : of_vehicle) {
      if (sensor->makes_scan_by(team.now)) return 1;
    }
  }
  return team.size() >= kManyVehicles ? kVehiclesAtATime : 0;
}

/// A broken contract is told with its vehicle and the instant.
void rethrow(const FirstException& failure, const Team& team) {
  try {
    failure.rethrow();
  } catch (const ContractViolation& violation) {
    throw ContractViolation(team.names[failure.part()] + " at " + std::to_string(to_seconds(team.now)) +
                            " s: " + violation.what());
  }
}

}  // namespace

void SweepSchedule::sense_and_step(Team& team, const Truth& truth, StageClock& clock) {
  const int share = vehicles_at_a_time(team);
  if (share == 1) {
    trace_with_steps(team, truth, clock);
    return;
  }
  {
    const auto timed = clock.measure(Stage::kSensors);
    FirstException failure;
#pragma omp parallel for schedule(dynamic, std::max(share, 1)) if (share > 0)
    for (int i = 0; i < team.size(); ++i) failure.guard(i, [&] { team.sense(i, truth); });
    rethrow(failure, team);
  }
  const auto timed = clock.measure(Stage::kAgents);
  FirstException failure;
#pragma omp parallel for schedule(dynamic, std::max(share, 1)) if (share > 0)
  for (int i = 0; i < team.size(); ++i) failure.guard(i, [&] { team.step(i); });
  rethrow(failure, team);
}

// The sweeps that are due, in parts.
void SweepSchedule::begin_sweeps(const Team& team, const Truth& truth) {
  sweeps_.clear();
  for (int i = 0; i < team.size(); ++i) {
    for (const auto& sensor : team.sensors[i]) {
      if (sensor->makes_scan_by(team.now)) sweeps_.push_back({sensor.get(), i, 0});
    }
    parts_left_[i] = 0;
  }
  FirstException failure;
#pragma omp parallel for schedule(dynamic, 1)
  for (Sweep& sweep : sweeps_) {
    failure.guard(sweep.vehicle, [&] { sweep.num_parts = sweep.sensor->begin_sweep(team.now, truth.history); });
  }
  rethrow(failure, team);

  parts_.clear();
  for (int s = 0; s < static_cast<int>(sweeps_.size()); ++s) {
    const Sweep& sweep = sweeps_[s];
    parts_left_[sweep.vehicle] += sweep.num_parts;
    const double step = step_s_[sweep.vehicle] > kLongStep_s ? step_s_[sweep.vehicle] : 0.0;
    for (int k = 0; k < sweep.num_parts; ++k) parts_.push_back({-step, sweep.sensor->heading_of_part(k), s, k});
  }
  std::sort(parts_.begin(), parts_.end());
}

// Threads share the parts of the sweeps. Who traces the last one of a vehicle goes on with its other sensors and its
// agent, while others trace: an agent that detects keeps one thread as busy as the sweeps keep the rest.
void SweepSchedule::trace_with_steps(Team& team, const Truth& truth, StageClock& clock) {
  const auto start = Clock::now();
  clock.add(Stage::kSensors, 0.0);
  begin_sweeps(team, truth);
  std::atomic<double> busy_s = 0.0, stepping_s = 0.0;
  FirstException failure;
#pragma omp parallel
  {
    const auto thread_start = Clock::now();
    const auto sense_and_step_one = [&](VehicleId i) {
      team.sense(i, truth);
      const auto step_start = Clock::now();
      team.step(i);
      step_s_[i] = seconds_since(step_start);
      stepping_s += step_s_[i];
    };
#pragma omp for schedule(dynamic, 1)
    for (int i = 0; i < team.size(); ++i) {
      if (parts_left_[i] == 0) failure.guard(i, [&] { sense_and_step_one(i); });
    }
#pragma omp for schedule(dynamic, kPartsAtATime) nowait
    for (const Part& part : parts_) {
      const Sweep& sweep = sweeps_[part.sweep];
      failure.guard(sweep.vehicle, [&] {
        sweep.sensor->trace_part(part.number);
        if (--parts_left_[sweep.vehicle] == 0) sense_and_step_one(sweep.vehicle);
      });
    }
    busy_s += seconds_since(thread_start);
  }
  rethrow(failure, team);
  const double agents_s = seconds_since(start) * stepping_s / busy_s;
  clock.add(Stage::kAgents, agents_s);
  clock.add(Stage::kSensors, seconds_since(start) - agents_s);
}

}  // namespace swiftlet::sim
