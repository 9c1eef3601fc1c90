// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet::sim {

/// Largest number of threads of a run. More are a mistake: they cost memory and time to start.
inline constexpr int kMaxThreads = 1024;

/// Processors that this process may use, at least 1: the affinity mask, less where the quota of a control group
/// (containers, version 1 or 2) or a Slurm job (SLURM_CPUS_PER_TASK, SLURM_CPUS_ON_NODE) gives less.
int available_processors();

/// Threads of a run without a number of its own: OMP_NUM_THREADS where it is set, otherwise available_processors().
/// Throws InputError when OpenMP is set to more than kMaxThreads.
int default_threads();

/// Makes default_threads() the number of OpenMP's threads too, for loops of this thread and its forks.
void limit_openmp();

}  // namespace swiftlet::sim
