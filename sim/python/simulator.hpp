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
#include "sim/python/use.hpp"
#include "swiftlet/sim/run/run_directory.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::python {

/// World that several simulators share, with its configuration.
struct BuiltWorld {
  sim::World world;
  std::string config;  ///< type and settings
  std::uint64_t seed = 0;
};

/// Deletes objects created by this process. A forked process keeps its copies: their threads do not exist there, and
/// their files belong to the parent.
struct DeleteUnlessForked {
  template <class T>
  void operator()(T* object) const {
    if (!was_forked()) delete object;
  }
  static bool was_forked();
};

/// Python interface of a simulation. C++ runs without the GIL; one thread at a time.
class Simulator {
 public:
  /// @param out  run directory, which appears when the run is finished; none: nothing is written
  Simulator(const ReadScenario& scenario, int threads, const BuiltWorld* world,
            const std::optional<std::filesystem::path>& out);

  /// Runs up to `count` ticks, at most until the run is over. Returns the number of ticks.
  int tick(int count);
  /// Runs until the time `until_s` or the end of the run. Ctrl-C stops after the current tick.
  void run(double until_s);
  bool finished() const { return simulation_->finished(); }
  /// Ends recording and moves the run directory to its place.
  void finish();
  std::string summary_json() const;

  const std::shared_ptr<sim::Simulation>& simulation() const { return simulation_; }
  const BuiltWorld& world() const { return world_; }
  /// Set during a call; a second call meanwhile is rejected.
  const std::shared_ptr<std::atomic<bool>>& in_use() const { return in_use_; }
  Table& states() { return states_; }
  const std::shared_ptr<Commands>& commands() const { return commands_; }
  Table events() const;

 private:
  class Flight;
  std::string timed_summary() const;
  void advance();

  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  BuiltWorld world_;
  std::shared_ptr<Commands> commands_;
  std::shared_ptr<sim::Simulation> simulation_;
  std::unique_ptr<sim::RunDirectory, DeleteUnlessForked> directory_;
  Table states_;
  std::vector<sim::Event> events_;
  double setup_wall_s_ = 0.0;
  double wall_s_ = 0.0;
  std::shared_ptr<std::atomic<bool>> in_use_ = std::make_shared<std::atomic<bool>>(false);
  bool broken_ = false;  // a tick threw an exception, so further calls are refused
};

}  // namespace swiftlet::python
