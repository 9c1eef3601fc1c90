// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/python/commanded.hpp"
#include "sim/python/fields.hpp"
#include "sim/python/scenario.hpp"
#include "swiftlet/sim/run/run_directory.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::python {

/// A simulation as Python drives it. C++ runs without Python's lock; one thread at a time.
class Simulator {
 public:
  /// @param out  run directory, which appears when the run is finished; none: nothing is written
  Simulator(const ReadScenario& scenario, int threads, std::optional<sim::World> world,
            const std::optional<std::filesystem::path>& out);

  /// Whole ticks, at most until the run is over; how many there were.
  int tick(int count);
  /// Until that instant or the end of the run. Ctrl-C ends it after the present tick.
  void run(double until_s);
  bool finished() const { return simulation_->finished(); }
  /// Ends recording and puts the run directory in place.
  void finish();
  std::string summary_json() const;

  const std::shared_ptr<sim::Simulation>& simulation() const { return simulation_; }
  const sim::World& world() const { return world_; }
  Table& states() { return states_; }
  const std::shared_ptr<Commands>& commands() const { return commands_; }
  Table events() const { return Table::copy_of(std::span<const sim::Event>(events_)); }

 private:
  /// One thread at a time, and not after an error.
  class Use;
  void advance();

  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  sim::World world_;
  std::shared_ptr<Commands> commands_;
  std::shared_ptr<sim::Simulation> simulation_;
  std::unique_ptr<sim::RunDirectory> directory_;
  Table states_;
  std::vector<sim::Event> events_;
  double setup_wall_s_ = 0.0;
  double wall_s_ = 0.0;
  std::atomic<bool> in_use_ = false;
  bool broken_ = false;
};

}  // namespace swiftlet::python
