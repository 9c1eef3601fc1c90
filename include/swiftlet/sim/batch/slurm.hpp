// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "swiftlet/sim/batch/batch_plan.hpp"

namespace swiftlet::sim {

/// Scripts of a Slurm job array that runs a batch, and of the job that merges its results.
struct SlurmScripts {
  int num_tasks = 1;
  int episodes_per_task = 1;
  int time_limit_min = 0;  ///< time limit of each task
  std::string array;       ///< content of array.sbatch
  std::string merge;       ///< content of merge.sbatch
};

/// @param out      directory for the results
/// @param program  swiftlet executable that the tasks call; both must lie on a file system shared by the nodes
SlurmScripts make_slurm_scripts(const BatchPlan& plan, const std::filesystem::path& out,
                                const std::filesystem::path& program);

struct SlurmFiles {
  std::filesystem::path array, merge;
};

/// Writes both scripts to the directory `out`/slurm and returns their paths.
SlurmFiles write_slurm_scripts(const SlurmScripts& scripts, const std::filesystem::path& out);

struct SlurmJobs {
  std::string array, merge;  ///< job numbers
};

/// Submits both scripts with sbatch. The merge starts after all tasks have ended, failed ones too. Throws
/// std::runtime_error if sbatch fails.
SlurmJobs submit(const SlurmFiles& files);

}  // namespace swiftlet::sim
