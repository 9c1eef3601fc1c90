// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace swiftlet::sim {

/// One of `count` parts of a batch; counted from 0 here, from 1 where people read or type it.
struct Shard {
  int index = 0;
  int count = 1;
  std::string source;  ///< "--shard", or the environment variables that told it

  bool whole() const { return count == 1; }
  std::string str() const { return std::to_string(index + 1) + "/" + std::to_string(count); }
};

using Environment = std::function<std::optional<std::string>(const std::string& name)>;
Environment system_environment();

/// "2/8": the second of eight. Throws InputError.
Shard parse_shard(const std::string& text);

/// The part that a cluster gives this process; the whole when nothing tells of one. It is an element of a Slurm array
/// (SLURM_ARRAY_TASK_ID) or of an indexed Kubernetes job (JOB_COMPLETION_INDEX, of SWIFTLET_NUM_SHARDS). In it, it is a
/// rank (OMPI_COMM_WORLD_RANK, PMI_RANK, SLURM_PROCID). Throws InputError when what is told makes no sense.
Shard shard_of_environment(const Environment& environment);

}  // namespace swiftlet::sim
