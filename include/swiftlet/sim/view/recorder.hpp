// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "swiftlet/sim/view/tick_view.hpp"

namespace swiftlet::sim {

/// Writes one output format. Everything it creates lies in RunInfo::directory.
class Recorder {
 public:
  virtual ~Recorder() = default;
  virtual void begin(const RunInfo& info) = 0;
  /// Asked before each tick: are the agents to tell what they want drawn (Action::overlays)? No result hangs on it.
  virtual bool wants_overlays(TimeNs /*now*/) const { return false; }
  /// The state at t = 0. No sensor has measured and no agent has stepped, so estimates are invalid.
  virtual void write_start(const TickView& start) { write(start); }
  virtual void write(const TickView& tick) = 0;
  /// Flushes and closes; returns the paths written, relative to the run directory. Throws std::runtime_error when
  /// anything could not be written (disk full).
  virtual std::vector<std::filesystem::path> finish() = 0;
};

/// Where a recorder writes, and what of it: two recorders must not write the same.
struct RecorderOutput {
  std::string key;    ///< of the configuration that names the place; "type": the place is fixed
  std::string place;  ///< file or folder in the run directory
  bool is_file = false;
  std::string kind;                   ///< of the files in a folder: recorders of two kinds share one
  std::vector<std::string> vehicles;  ///< by name; empty: all
  std::vector<std::string> streams;   ///< sensors or topics by name; empty: all
};

/// A base of the configuration of every recorder: the scenario asks it before the flight.
struct TellsOutput {
  virtual ~TellsOutput() = default;
  virtual RecorderOutput output() const = 0;
};

}  // namespace swiftlet::sim
