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
/// @param what  noun of the progress text: "flights" in "12 of 40 flights"
void parallel_for(const Experiment& experiment, std::size_t count, const std::string& what,
                  const std::function<void(std::size_t index)>& work);

/// Scenario file (path or name) with overrides ("vehicles[0].start.yaw_deg", "90") and a seed.
sim::Scenario scenario_with(const std::string& file, std::uint64_t seed,
                            std::vector<std::pair<std::string, std::string>> overrides = {});

/// Callbacks by which an experiment measures its flights beyond their summaries. All run on the thread of run `index`.
struct FlightNotes {
  std::function<void(std::size_t index, const sim::Simulation&)> after_tick = {};
  /// Stores the results of after_tick as numbers and restores them, so that a finished flight can be reused.
  std::function<std::vector<double>(std::size_t index)> write = {};
  std::function<void(std::size_t index, std::span<const double> numbers)> read = {};
  /// Ends a run before its scenario does, when it is true after a tick.
  std::function<bool(const sim::Simulation&)> is_over = {};
};

/// Flies every scenario to its end, several at a time; the summaries in the order of the scenarios. Finished flights
/// are in flights.jsonl and, when the experiment is resumed, read from there (their metrics, without radio and timing).
std::vector<sim::RunSummary> fly(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios,
                                 const FlightNotes& notes = {});
/// Overload without stored notes: flights are flown again on resume.
/// @param after_tick  called after each tick of run `index`, on its thread. Keep results by index.
std::vector<sim::RunSummary> fly(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios,
                                 const std::function<void(std::size_t index, const sim::Simulation&)>& after_tick);

/// One metric of many runs, in their order; NaN where not measured.
/// @param vehicle  empty: the metric of the whole run
std::vector<double> metric_of(const std::vector<sim::RunSummary>& runs, const std::string& name,
                              const std::string& vehicle = {});

struct MeanAndDeviation {
  double mean = 0.0;
  double deviation = 0.0;  ///< sample standard deviation (n - 1)
  std::size_t count = 0;   ///< samples that are not NaN
};
MeanAndDeviation mean_and_deviation(const std::vector<double>& samples);

}  // namespace swiftlet::tools
