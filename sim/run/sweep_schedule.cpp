// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/sweep_schedule.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/sim/parallel/crew.hpp"
#include "swiftlet/sim/parallel/first_exception.hpp"

namespace swiftlet::sim {
namespace {

// [vehicles] Least number from which vehicles without LiDAR are distributed over threads, and size of the blocks.
// Smaller values synchronize more than they save.
constexpr int kManyVehicles = 16;
constexpr int kVehiclesAtATime = 4;
// [-] Parts of sweeps that a thread takes at once. Larger values synchronize less and balance worse.
constexpr int kPartsAtATime = 16;

// [s] Duration of an agent's step above which the sweeps for that agent are traced first, so that the agent starts
// early.
constexpr double kLongStep_s = 1e-3;

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Number of vehicles per block: each vehicle with a due LiDAR sweep forms its own block; other sensors and controllers
// are distributed only for many vehicles. Otherwise one thread processes all, which costs less than sharing.
int vehicles_at_a_time(const Team& team) {
  if (team.size() < 2) return 1;  // a single LiDAR is traced in parallel parts
  for (const auto& of_vehicle : team.sensors) {
    for (const auto& sensor : of_vehicle) {
      if (sensor->makes_scan_by(team.now)) return 1;
    }
  }
  return team.size() >= kManyVehicles ? kVehiclesAtATime : team.size();
}

/// Adds the vehicle and the time to a contract violation.
template <class Act>
void for_vehicle(const Team& team, VehicleId i, const Act& act) {
  try {
    act();
  } catch (const ContractViolation& violation) {
    throw ContractViolation(fmt::format("{} at {:f} s: {}", team.names[i], to_seconds(team.now), violation.what()));
  }
}

}  // namespace

void SweepSchedule::sense_and_step(Team& team, const Truth& truth, StageClock& clock) {
  const int share = vehicles_at_a_time(team);
  if (share == 1 && team.size() > 1) {
    trace_with_steps(team, truth, clock);
    return;
  }
  {
    const auto timed = clock.measure(Stage::kSensors);
    parallel_for(team.size(), share, [&](int i) { for_vehicle(team, i, [&] { team.sense(i, truth); }); });
  }
  const auto timed = clock.measure(Stage::kAgents);
  parallel_for(team.size(), share, [&](int i) { for_vehicle(team, i, [&] { team.step(i); }); });
}

// Begins the due sweeps and collects their parts.
void SweepSchedule::begin_sweeps(const Team& team, const Truth& truth) {
  sweeps_.clear();
  for (int i = 0; i < team.size(); ++i) {
    for (const auto& sensor : team.sensors[i]) {
      if (sensor->makes_scan_by(team.now)) sweeps_.push_back({sensor.get(), i, 0});
    }
    parts_left_[i] = 0;
  }
  parallel_for(static_cast<int>(sweeps_.size()), 1, [&](int s) {
    Sweep& sweep = sweeps_[s];
    for_vehicle(team, sweep.vehicle, [&] { sweep.num_parts = sweep.sensor->begin_sweep(team.now, truth.history); });
  });

  parts_.clear();
  for (int s = 0; s < static_cast<int>(sweeps_.size()); ++s) {
    const Sweep& sweep = sweeps_[s];
    parts_left_[sweep.vehicle] += sweep.num_parts;
    const double step = step_s_[sweep.vehicle] > kLongStep_s ? step_s_[sweep.vehicle] : 0.0;
    for (int k = 0; k < sweep.num_parts; ++k) parts_.push_back({-step, sweep.sensor->heading_of_part(k), s, k});
  }
  std::sort(parts_.begin(), parts_.end());
  without_sweep_.clear();
  for (int i = 0; i < team.size(); ++i) {
    if (parts_left_[i] == 0) without_sweep_.push_back(i);
  }
}

// Threads share the parts of the sweeps. The thread that traces the last part of a vehicle continues with its other
// sensors and its agent while others trace, so that slow agents (detection) run in parallel with sweeps.
void SweepSchedule::trace_with_steps(Team& team, const Truth& truth, StageClock& clock) {
  const auto start = Clock::now();
  clock.add(Stage::kSensors, 0.0);
  begin_sweeps(team, truth);

  std::atomic<double> busy_s = 0.0, stepping_s = 0.0;
  const auto sense_and_step = [&](VehicleId i) {
    team.sense(i, truth);
    const auto step_start = Clock::now();
    team.step(i);
    step_s_[i] = seconds_since(step_start);
    stepping_s += step_s_[i];
  };
  FirstException failure;  // the first by vehicle index, independent of timing
  const auto guard = [&](VehicleId i, const auto& act) { failure.guard(i, [&] { for_vehicle(team, i, act); }); };
  const int num_without = static_cast<int>(without_sweep_.size());
  const int num_parts = static_cast<int>(parts_.size());
  parallel_for(
      num_without + (num_parts + kPartsAtATime - 1) / kPartsAtATime, 1,
      [&](int k) {
        const auto begin = Clock::now();
        if (k < num_without) {
          guard(without_sweep_[k], [&] { sense_and_step(without_sweep_[k]); });
        } else {
          const int first = (k - num_without) * kPartsAtATime;
          for (int p = first; p < std::min(first + kPartsAtATime, num_parts); ++p) {
            const Part& part = parts_[p];
            const Sweep& sweep = sweeps_[part.sweep];
            guard(sweep.vehicle, [&] {
              sweep.sensor->trace_part(part.number);
              if (--parts_left_[sweep.vehicle] == 0) sense_and_step(sweep.vehicle);
            });
          }
        }
        busy_s += seconds_since(begin);
      },
      Sharing::kInOrder);
  failure.rethrow();
  const double agents_s = seconds_since(start) * stepping_s / busy_s;
  clock.add(Stage::kAgents, agents_s);
  clock.add(Stage::kSensors, seconds_since(start) - agents_s);
}

}  // namespace swiftlet::sim
