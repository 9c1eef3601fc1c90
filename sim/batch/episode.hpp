// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "swiftlet/sim/batch/batch_plan.hpp"
#include "swiftlet/sim/metrics/metric_table.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::sim {

/// Outcome, metrics and computing times of one episode.
struct EpisodeResult {
  std::string outcome;
  std::uint64_t state_hash = 0;
  double simulated_s = 0.0;
  std::vector<MetricRow> metrics;
  // Values that depend on the machine and on the order of the episodes:
  double setup_wall_s = 0.0;   ///< time for reading the scenario and creating world and vehicles
  double flight_wall_s = 0.0;  ///< time for the simulation
  bool built_world = false;    ///< false: the world was in the cache
};

/// Serializes a result for the pipe from a worker process; NaN and infinite metrics become NaN.
std::string to_bytes(const EpisodeResult& result);
EpisodeResult episode_result_from_bytes(const std::string& bytes);

/// Keeps the most recently used worlds for following episodes.
class WorldCache {
 public:
  /// @param capacity  largest number of worlds in memory
  explicit WorldCache(std::size_t capacity = 2) : capacity_(capacity) {}
  /// Returns the world of a scenario, and true if this call has built it, false if it was in the cache.
  std::pair<World, bool> get(const Scenario& scenario);

 private:
  std::size_t capacity_;
  /// Worlds by their type, seed and configuration; most recently used first.
  std::list<std::pair<std::string, World>> worlds_;
};

/// Flies episodes of a batch one after another and caches their worlds and scenarios. Writes no files: recorders and
/// snapshots are switched off.
class EpisodeRunner {
 public:
  explicit EpisodeRunner(const BatchPlan& plan)
      : plan_(plan), worlds_(plan.config().variants.size() > 1 ? kWorldsOfVariants : kWorlds) {}
  /// @param id  number of the episode, BatchPlan::episode()
  EpisodeResult fly(std::uint64_t id);

 private:
  /// [-] Number of worlds in memory for one variant, and for several. Larger values take more memory and build fewer
  /// worlds again.
  static constexpr std::size_t kWorlds = 2, kWorldsOfVariants = 3;

  Scenario scenario_of(const Episode& episode);

  const BatchPlan& plan_;
  WorldCache worlds_;
  std::size_t point_ = 0;                      ///< sweep point of the last episode
  std::map<std::size_t, Scenario> scenarios_;  ///< scenarios of this point, indexed by variant
};

}  // namespace swiftlet::sim
