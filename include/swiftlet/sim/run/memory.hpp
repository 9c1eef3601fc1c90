// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::sim {

/// Memory available to this process: the machine's, or less by its resource limits, limit_memory(), its control groups
/// (containers, version 1 or 2) or its Slurm job (SLURM_MEM_PER_NODE, SLURM_MEM_PER_CPU x SLURM_CPUS_ON_NODE).
double available_memory_bytes();

/// Limits the memory of this process and of the workers that it starts later.
void limit_memory(double limit_mb);

/// Throws InputError, with key and number, when the memory required by the vehicles' settings exceeds the available
/// memory.
void require_memory(const Scenario& scenario);

/// Throws InputError when the need of one key exceeds the available memory.
void require_memory(const std::string& key, double bytes);

}  // namespace swiftlet::sim
