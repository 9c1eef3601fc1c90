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
#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"
#include "swiftlet/sim/view/recorder.hpp"

namespace swiftlet::sim {

/// The static part of a run, ready to trace; runs with the same world and seed may share one.
struct World {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const StaticScene> static_scene;
};
World build_world(const Module& config, std::uint64_t seed);

/// One run in lockstep. The same scenario gives the same bits for any number of threads.
class Simulation {
 public:
  /// @param threads  for physics, sensors and agents; 0: default_threads()
  explicit Simulation(Scenario scenario, int threads = 0, std::optional<World> world = std::nullopt);
  ~Simulation();

  /// The scenario's recorders and cameras write into `directory` (which exists) from the next tick on.
  void attach_recorders(const std::filesystem::path& directory);
  /// One recorder more, which may be the caller's own.
  void attach(std::unique_ptr<Recorder> recorder, const std::filesystem::path& directory);

  void tick();
  bool finished() const;
  TimeNs now() const;
  const Scenario& scenario() const;
  const TickView& view() const;  ///< the last tick; before the first one, the start
  const RunInfo& info() const;
  /// Hash of every vehicle's true state and every sensor output so far, in tick order.
  std::uint64_t state_hash() const;
  /// Ends recording; the paths written, relative to the directory.
  std::vector<std::filesystem::path> finish();
  /// What the run came to so far; wall times other than the stages' are the caller's to fill in.
  RunSummary summary() const;

  /// From now on the steps of the agents are timed by stage. No bits change.
  void time_agents();
  /// How long their stages took since then, all agents together, by AgentStage. Agents step at the same time on several
  /// threads, so this may be more than the wall time of the stage "agents".
  std::vector<std::pair<std::string, double>> agent_stage_s() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace swiftlet::sim
