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

/// Result of one episode.
struct EpisodeResult {
  std::string outcome;
  std::uint64_t state_hash = 0;
  double simulated_s = 0.0;
  std::vector<MetricRow> metrics;
  // Machine-dependent values:
  double setup_wall_s = 0.0;  ///< reading the scenario, creating world and vehicles
  double flight_wall_s = 0.0;
  bool built_world = false;
};

std::string to_bytes(const EpisodeResult& result);
EpisodeResult episode_result_from_bytes(const std::string& bytes);

/// The most recently used worlds.
class WorldCache {
 public:
  explicit WorldCache(std::size_t capacity = 2) : capacity_(capacity) {}
  /// The world of a scenario, built unless cached.
  /// @return the world, and whether it was built by this call
  std::pair<World, bool> get(const Scenario& scenario);

 private:
  std::size_t capacity_;
  std::list<std::pair<std::string, World>> worlds_;  ///< most recently used first, with scenario keys
};

/// Flies episodes one after another and caches shared data. Writes no files; the only output is the metrics.
class EpisodeRunner {
 public:
  explicit EpisodeRunner(const BatchPlan& plan) : plan_(plan), worlds_(plan.config().variants.size() > 1 ? 3 : 2) {}
  EpisodeResult fly(std::uint64_t id);

 private:
  Scenario scenario_of(const Episode& episode);

  const BatchPlan& plan_;
  WorldCache worlds_;
  std::size_t point_ = 0;
  std::map<std::size_t, Scenario> scenarios_;  ///< scenarios of `point_`, indexed by variant
};

}  // namespace swiftlet::sim
