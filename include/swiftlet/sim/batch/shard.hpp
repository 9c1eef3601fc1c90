// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace swiftlet::sim {

/// One of `count` parts of a batch. The index counts from 0 here, from 1 in texts and options.
struct Shard {
  int index = 0;
  int count = 1;
  std::string source;  ///< origin of the numbers: "--shard" or the names of the environment variables

  bool whole() const { return count == 1; }
  std::string str() const { return std::to_string(index + 1) + "/" + std::to_string(count); }
};

using Environment = std::function<std::optional<std::string>(const std::string& name)>;
Environment system_environment();

/// "2/8": the second of eight. Throws InputError.
Shard parse_shard(const std::string& text);

/// The shard assigned to this process by a cluster; the whole batch without such variables. The shard is an element of
/// a Slurm array (SLURM_ARRAY_TASK_ID) or of an indexed Kubernetes job (JOB_COMPLETION_INDEX, of SWIFTLET_NUM_SHARDS),
/// and within it an MPI or Slurm rank (OMPI_COMM_WORLD_RANK, PMI_RANK, SLURM_PROCID). Throws InputError when the
/// variables are malformed or contradictory.
Shard shard_of_environment(const Environment& environment);

}  // namespace swiftlet::sim
