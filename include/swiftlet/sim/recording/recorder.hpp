// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "swiftlet/sim/recording/tick_view.hpp"

namespace swiftlet::sim {

/// Writes one output format. All its files lie in RunInfo::directory.
class Recorder {
 public:
  virtual ~Recorder() = default;
  virtual void begin(const RunInfo& info) = 0;
  /// Called before each tick: whether the agents fill Action::overlays. Does not affect results.
  virtual bool wants_overlays(TimeNs /*now*/) const { return false; }
  /// The state at t = 0. No sensor has measured and no agent has stepped, so estimates are invalid.
  virtual void write_start(const TickView& start) { write(start); }
  virtual void write(const TickView& tick) = 0;
  /// Flushes and closes; returns the written paths, relative to the run directory. Throws std::runtime_error when a
  /// write has failed (disk full).
  virtual std::vector<std::filesystem::path> finish() = 0;
};

/// Output location and content of a recorder; two recorders must not write the same.
struct RecorderOutput {
  std::string key;    ///< configuration key that sets the place; "type": the place is fixed
  std::string place;  ///< file or folder in the run directory
  bool is_file = false;
  /// Kind of the files in a folder; recorders of different kinds may share a folder
  std::string kind;
  std::vector<std::string> vehicles;  ///< names of the recorded vehicles; empty: all
  std::vector<std::string> streams;   ///< names of the recorded sensors or topics; empty: all
};

/// Base of the configuration of every recorder; the scenario checks its output before the flight.
struct OutputProvider {
  virtual ~OutputProvider() = default;
  virtual RecorderOutput output() const = 0;
};

}  // namespace swiftlet::sim
