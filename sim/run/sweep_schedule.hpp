// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <compare>
#include <vector>

#include "sim/run/team.hpp"
#include "swiftlet/sim/run/stage_clock.hpp"

namespace swiftlet::sim {

/// Shares the sensing and the steps of a tick among threads. Only the order of the work depends on how long it takes
/// and on how many threads there are; no result does.
class SweepSchedule {
 public:
  explicit SweepSchedule(int num_vehicles) : parts_left_(num_vehicles), step_s_(num_vehicles) {}

  void sense_and_step(Team& team, const Truth& truth, StageClock& clock);

 private:
  struct Sweep {
    Sensor* sensor = nullptr;
    VehicleId vehicle = 0;
    int num_parts = 0;
  };
  /// Part of a sweep. In order of who waits for it, then of its heading: what one vehicle's beams brought from memory
  /// serves the next one's.
  struct Part {
    double minus_step_s = 0.0;  // of the agent that waits, if it is a long one
    int heading = 0;
    int sweep = 0;
    int number = 0;

    auto operator<=>(const Part&) const = default;
  };

  void begin_sweeps(const Team& team, const Truth& truth);
  void trace_with_steps(Team& team, const Truth& truth, StageClock& clock);

  std::vector<Sweep> sweeps_;                 // due in this tick
  std::vector<Part> parts_;                   // of theirs
  std::vector<VehicleId> without_sweep_;      // in this tick
  std::vector<std::atomic<int>> parts_left_;  // by vehicle
  std::vector<double> step_s_;                // by vehicle: wall time of its agent's last step with a sweep
};

}  // namespace swiftlet::sim
