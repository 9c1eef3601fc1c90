// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::tools {

/// What an experiment keeps of a flight.
struct FinishedFlight {
  sim::RunSummary summary;    ///< scenario, seed, outcome, hash, duration and the rows of its metrics
  std::vector<double> notes;  ///< what the experiment itself counted
};

/// The finished flights of an experiment in flights.jsonl, a line each, written when they end: an experiment that was
/// killed need not fly them again. A last line that was cut is no flight.
class FlightLog {
 public:
  /// @param resume  read what is there; otherwise the file begins anew
  /// Throws std::runtime_error with path and reason when it cannot be written.
  FlightLog(const std::filesystem::path& file, bool resume);

  /// The same scenario (complete, with its seed) flown by the same revision of the program has the same key.
  static std::string key_of(const sim::Scenario& scenario);
  /// nullptr: still to be flown.
  const FinishedFlight* find(const std::string& key) const;
  void add(const std::string& key, const FinishedFlight& flight);  ///< from any thread

 private:
  bool read();
  std::filesystem::path path_;
  std::map<std::string, FinishedFlight> flights_;  ///< of earlier attempts
  std::mutex writing_;
  std::ofstream out_;
};

}  // namespace swiftlet::tools
