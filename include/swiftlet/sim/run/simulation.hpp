// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::sim {

/// The static part of a run, ready for ray tracing; runs with the same world and seed may share one.
struct World {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const StaticScene> static_scene;
};
World build_world(const Module& config, std::uint64_t seed);

/// One run in lockstep. The same scenario gives the same bits for any number of threads.
class Simulation {
 public:
  /// @param threads  number of threads for physics, sensors and agents; 0: default_threads()
  explicit Simulation(Scenario scenario, int threads = 0, std::optional<World> world = std::nullopt);
  ~Simulation();

  /// The scenario's recorders and cameras write into `directory` (which must exist) from the next tick on.
  void attach_recorders(const std::filesystem::path& directory);
  /// Attaches one more recorder, which may be the caller's own.
  void attach(std::unique_ptr<Recorder> recorder, const std::filesystem::path& directory);

  void tick();
  bool finished() const;
  TimeNs now() const;
  const Scenario& scenario() const;
  const TickView& view() const;  ///< the last tick; before the first one, the start state
  const RunInfo& info() const;
  /// Hash of every vehicle's true state and every sensor output so far, in tick order.
  std::uint64_t state_hash() const;
  /// Ends recording. Returns the written paths, relative to the directory.
  std::vector<std::filesystem::path> finish();
  /// Result of the run so far; the caller fills in wall times other than those of the stages.
  RunSummary summary() const;

  /// Enables timing of the agents by stage. Does not change results.
  void time_agents();
  /// Time spent by their stages since then, summed over all agents, by AgentStage. Agents run in parallel on several
  /// threads, so this may exceed the wall time of the stage "agents".
  std::vector<std::pair<std::string, double>> agent_stage_s() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace swiftlet::sim
