// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "swiftlet/sim/batch/batch_plan.hpp"
#include "swiftlet/sim/batch/result_store.hpp"
#include "swiftlet/sim/batch/shard.hpp"

namespace swiftlet::sim {

struct BatchOptions {
  std::filesystem::path out;
  int jobs = 1;
  Shard shard;
  std::vector<std::uint64_t> episodes;  ///< only these, in rising order; empty: all
  bool resume = false;
  bool retry = false;            ///< resume: also repeat episodes recorded as failed, crashed, timed_out, out_of_memory
  double memory_limit_mb = 0.0;  ///< per worker on this machine; 0: the batch file's limit
  std::function<bool()> canceled;
};

struct BatchProgress {
  std::uint64_t total = 0;  ///< number of selected episodes of this shard
  std::uint64_t done = 0;   ///< stored episodes, including failures and earlier starts
  std::uint64_t failed = 0;
  std::uint64_t flown = 0;  ///< since this start
  int running = 0;
};

struct BatchOutcome {
  bool complete = false;  ///< false: canceled
  BatchProgress progress;
  std::map<std::string, std::uint64_t> by_status;
  std::filesystem::path database;
};

/// OUT/results.sqlite, or of a shard OUT/shards/2-of-8.sqlite.
std::filesystem::path database_path(const std::filesystem::path& out, const Shard& shard);

/// Flies the missing episodes and stores each as it ends. Only one process at a time may write to a database.
/// Throws InputError when `out` holds results and `resume` is not set, or results of a different batch.
BatchOutcome run_batch(const BatchPlan& plan, const BatchOptions& options,
                       const std::function<void(const BatchProgress&)>& report);

BatchInfo info_of(const BatchPlan& plan);

/// Throws InputError, naming the difference, unless both describe the same batch of the same version.
void require_same_batch(const BatchInfo& stored, const BatchInfo& wanted, const std::filesystem::path& database);

}  // namespace swiftlet::sim
