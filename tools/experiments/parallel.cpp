// SPDX-License-Identifier: BSD-3-Clause
#include "parallel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "flight_log.hpp"

namespace swiftlet::tools {

void parallel_for(const Experiment& experiment, std::size_t count, const std::string& what,
                  const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next = 0, done = 0;
  std::atomic<bool> failed = false;
  std::vector<std::exception_ptr> errors(count);
  std::mutex telling;
  const auto run = [&] {
    for (std::size_t index = next++; index < count && !failed; index = next++) {
      try {
        work(index);
      } catch (...) {
        errors[index] = std::current_exception();
        failed = true;
      }
      const std::size_t finished = ++done;
      const std::lock_guard lock(telling);
      experiment.progress(static_cast<double>(finished) / static_cast<double>(count),
                          fmt::format("{} of {} {}", finished, count, what));
    }
  };
  std::vector<std::thread> threads;
  const std::size_t wanted = std::min<std::size_t>(static_cast<std::size_t>(std::max(experiment.jobs(), 1)), count);
  for (std::size_t i = 1; i < wanted; ++i) threads.emplace_back(run);
  run();
  for (std::thread& thread : threads) thread.join();
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

sim::Scenario scenario_with(const std::string& file, std::uint64_t seed,
                            std::vector<std::pair<std::string, std::string>> overrides) {
  overrides.emplace_back("seed", std::to_string(seed));
  return sim::load_scenario(file, overrides);
}

std::vector<sim::RunSummary> fly(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios,
                                 const FlightNotes& notes) {
  FlightLog* log = notes.after_tick && !notes.write ? nullptr : experiment.flight_log();
  std::vector<sim::RunSummary> summaries(scenarios.size());
  parallel_for(experiment, scenarios.size(), "flights", [&](std::size_t index) {
    const std::string key = log != nullptr ? FlightLog::key_of(scenarios[index]) : std::string();
    if (const FinishedFlight* flown = log != nullptr ? log->find(key) : nullptr) {
      summaries[index] = flown->summary;
      if (notes.read) notes.read(index, flown->notes);
      return;
    }
    sim::Simulation simulation(scenarios[index], 1);
    while (!simulation.finished()) {
      simulation.tick();
      if (notes.after_tick) notes.after_tick(index, simulation);
      if (notes.is_over && notes.is_over(simulation)) break;
    }
    summaries[index] = simulation.summary();
    if (log != nullptr) log->add(key, {summaries[index], notes.write ? notes.write(index) : std::vector<double>()});
  });
  return summaries;
}

std::vector<sim::RunSummary> fly(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios,
                                 const std::function<void(std::size_t, const sim::Simulation&)>& after_tick) {
  return fly(experiment, scenarios, FlightNotes{.after_tick = after_tick});
}

std::vector<double> metric_of(const std::vector<sim::RunSummary>& runs, const std::string& name,
                              const std::string& vehicle) {
  std::vector<double> values;
  for (const sim::RunSummary& run : runs) {
    const sim::MetricRow* row = run.metrics.find(name, vehicle);
    if (row == nullptr)
      throw std::logic_error(fmt::format("scenario '{}' has no metric '{}' of '{}'", run.scenario, name, vehicle));
    values.push_back(row->value);
  }
  return values;
}

MeanAndDeviation mean_and_deviation(const std::vector<double>& samples) {
  MeanAndDeviation result;
  double sum = 0.0, squares = 0.0;
  for (const double sample : samples) {
    if (std::isnan(sample)) continue;
    sum += sample;
    ++result.count;
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (result.count == 0) return {nan, nan, 0};
  result.mean = sum / static_cast<double>(result.count);
  for (const double sample : samples) {
    if (!std::isnan(sample)) squares += (sample - result.mean) * (sample - result.mean);
  }
  result.deviation = result.count > 1 ? std::sqrt(squares / static_cast<double>(result.count - 1)) : 0.0;
  return result;
}

}  // namespace swiftlet::tools
