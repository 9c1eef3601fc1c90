// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "experiment.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/run/summary.hpp"

namespace swiftlet::tools {

/// Calls work(0) ... work(count - 1) on as many threads as the experiment has jobs. Work that writes only to its own
/// slot gives the same results for any number of jobs. The exception of the lowest index is thrown again.
/// @param what  of the progress: "12 of 40 flights"
void parallel_for(const Experiment& experiment, std::size_t count, const std::string& what,
                  const std::function<void(std::size_t index)>& work);

/// Scenario file (path or name) with overrides ("vehicles[0].start.yaw_deg", "90") and a seed of its own.
sim::Scenario scenario_with(const std::string& file, std::uint64_t seed,
                            std::vector<std::pair<std::string, std::string>> overrides = {});

/// What an experiment notes of its flights beside their summaries. All are called on the thread of run `index`.
struct FlightNotes {
  std::function<void(std::size_t index, const sim::Simulation&)> after_tick = {};
  /// What after_tick has noted, as numbers, and back again: so that a finished flight need not be flown a second time.
  std::function<std::vector<double>(std::size_t index)> write = {};
  std::function<void(std::size_t index, std::span<const double> numbers)> read = {};
  /// Ends a run before its scenario does, when it is true after a tick.
  std::function<bool(const sim::Simulation&)> is_over = {};
};

/// Flies every scenario to its end, several at a time; the summaries in the order of the scenarios. Finished flights
/// are in flights.jsonl and, when the experiment is resumed, read from there (their metrics, without radio and timing).
std::vector<sim::RunSummary> fly(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios,
                                 const FlightNotes& notes = {});
/// The same for notes that cannot be written: such flights are flown again.
/// @param after_tick  called after each tick of run `index`, on its thread. Keep results by index.
std::vector<sim::RunSummary> fly(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios,
                                 const std::function<void(std::size_t index, const sim::Simulation&)>& after_tick);

/// One metric of many runs, in their order; NaN where it was not measured.
/// @param vehicle  empty: the metric of the whole run
std::vector<double> metric_of(const std::vector<sim::RunSummary>& runs, const std::string& name,
                              const std::string& vehicle = {});

struct MeanAndDeviation {
  double mean = 0.0;
  double deviation = 0.0;  ///< of the samples (n - 1)
  std::size_t count = 0;   ///< samples that are not NaN
};
MeanAndDeviation mean_and_deviation(const std::vector<double>& samples);

}  // namespace swiftlet::tools
