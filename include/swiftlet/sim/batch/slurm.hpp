// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "swiftlet/sim/batch/batch_plan.hpp"

namespace swiftlet::sim {

/// Job array for a Slurm cluster and the job that merges its results.
struct SlurmScripts {
  int num_tasks = 1;
  int episodes_per_task = 1;
  int time_limit_min = 0;
  std::string array;  ///< content of array.sbatch
  std::string merge;  ///< content of merge.sbatch
};

/// @param program  swiftlet executable that the tasks call; it and `out` must lie on a file system shared by the nodes
SlurmScripts make_slurm_scripts(const BatchPlan& plan, const std::filesystem::path& out,
                                const std::filesystem::path& program);

struct SlurmFiles {
  std::filesystem::path array, merge;
};

/// Writes both into OUT/slurm.
SlurmFiles write_slurm_scripts(const SlurmScripts& scripts, const std::filesystem::path& out);

struct SlurmJobs {
  std::string array, merge;  ///< job numbers
};

/// Submits both with sbatch; the merge starts after all tasks have ended. Throws std::runtime_error.
SlurmJobs submit(const SlurmFiles& files);

}  // namespace swiftlet::sim
