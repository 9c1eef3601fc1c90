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

/// Stored result of a flight.
struct FinishedFlight {
  sim::RunSummary summary;    ///< scenario, seed, outcome, hash, duration and the rows of its metrics
  std::vector<double> notes;  ///< numbers from FlightNotes::write
};

/// The finished flights of an experiment in flights.jsonl, one line each, written when a flight ends, so that a killed
/// experiment can resume. Incomplete lines are skipped.
class FlightLog {
 public:
  /// @param resume  read the existing file; otherwise overwrite it
  /// Throws std::runtime_error with path and reason when it cannot be written.
  FlightLog(const std::filesystem::path& file, bool resume);

  /// Hash of the complete scenario, with its seed, and of the program's revision.
  static std::string key_of(const sim::Scenario& scenario);
  /// nullptr: not flown yet.
  const FinishedFlight* find(const std::string& key) const;
  void add(const std::string& key, const FinishedFlight& flight);  ///< from any thread

 private:
  bool read();
  std::filesystem::path path_;
  std::map<std::string, FinishedFlight> flights_;  ///< read from earlier attempts
  std::mutex writing_;
  std::ofstream out_;
};

}  // namespace swiftlet::tools
