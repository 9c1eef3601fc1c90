// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "swiftlet/sim/batch/batch_config.hpp"
#include "swiftlet/sim/batch/shard.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::sim {

/// One run of a batch, identified by variant, sweep point and seed.
struct Episode {
  std::uint64_t id = 0;
  std::size_t point = 0;  ///< index of the sweep point
  std::size_t variant = 0;
  std::uint64_t seed = 0;
};

/// All episodes of a batch file, numbered. Variants of one point and seed have neighboring numbers.
class BatchPlan {
 public:
  /// Reads the batch file and every scenario that it names, and checks every swept key. Throws InputError.
  explicit BatchPlan(const std::filesystem::path& file, const ConfigChanges& overrides = {});

  const BatchConfig& config() const { return config_; }
  const std::filesystem::path& file() const { return file_; }  ///< absolute
  const std::vector<std::vector<std::string>>& points() const { return points_; }
  const std::vector<std::uint64_t>& seeds() const { return seeds_; }

  std::uint64_t num_episodes() const;
  Episode episode(std::uint64_t id) const;
  Scenario scenario_of(const Episode& episode) const;
  /// The `swiftlet run ...` command that repeats this episode alone, with its recorders.
  std::string command_of(const Episode& episode) const;
  /// Equal for episodes that may share one world.
  std::uint64_t group_of(const Episode& episode) const;
  /// The episodes of one shard: a contiguous part of all of them in the order of their groups.
  std::vector<std::uint64_t> episodes_of(const Shard& shard) const;
  /// Hash of everything that can change a result: scenarios with all their defaults, models, named files, points,
  /// seeds. Independent of comments, key order, time-outs and recorders.
  const std::string& fingerprint() const { return fingerprint_; }

 private:
  ConfigChanges changes_of(const Episode& episode) const;
  std::string make_fingerprint() const;

  std::filesystem::path file_;
  BatchConfig config_;
  std::vector<std::string> scenarios_;  ///< file or name, indexed by variant
  std::vector<bool> world_is_fixed_;    ///< indexed by variant; true: the world does not depend on the episode's seed
  std::vector<std::vector<std::string>> points_;
  std::vector<std::uint64_t> seeds_;
  std::string fingerprint_;
};

}  // namespace swiftlet::sim
