// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet::sim {

/// Largest number of threads of a run. Larger numbers are rejected: they cost memory and start-up time.
inline constexpr int kMaxThreads = 1024;

/// Processors available to this process, at least 1: by the affinity mask, the quota of a control group (containers,
/// version 1 or 2) and the Slurm job (SLURM_CPUS_PER_TASK, SLURM_CPUS_ON_NODE).
int available_processors();

/// Threads of a run that does not set a number: OMP_NUM_THREADS where it is set, otherwise available_processors().
/// Throws InputError when OpenMP is set to more than kMaxThreads.
int default_threads();

/// Sets the number of OpenMP threads to default_threads() for parallel loops of this thread and of processes that it
/// forks.
void limit_openmp();

}  // namespace swiftlet::sim
