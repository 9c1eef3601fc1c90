// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <compare>
#include <vector>

#include "sim/run/team.hpp"
#include "swiftlet/sim/run/stage_clock.hpp"

namespace swiftlet::sim {

/// Distributes sensing and agent steps of a tick over threads. Timing and number of threads affect only the order of
/// the work, never the results.
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
  /// Part of a sweep. Sorted by the duration of the waiting agent's step, then by direction: beams of different
  /// vehicles in similar directions share data in the caches.
  struct Part {
    double minus_step_s = 0.0;  // negative step duration of the waiting agent; 0: short
    int heading = 0;
    int sweep = 0;
    int number = 0;

    auto operator<=>(const Part&) const = default;
  };

  void begin_sweeps(const Team& team, const Truth& truth);
  void trace_with_steps(Team& team, const Truth& truth, StageClock& clock);

  std::vector<Sweep> sweeps_;                 // due in this tick
  std::vector<Part> parts_;                   // parts of the due sweeps
  std::vector<VehicleId> without_sweep_;      // vehicles without due sweep
  std::vector<std::atomic<int>> parts_left_;  // indexed by vehicle
  std::vector<double> step_s_;                // indexed by vehicle: wall time of its agent's last step with a sweep
};

}  // namespace swiftlet::sim
