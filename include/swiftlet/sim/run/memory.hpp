// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::sim {

/// What this process may take: the machine's memory, or less by its resource limits, limit_memory(), its control groups
/// (containers, version 1 or 2) or its Slurm job (SLURM_MEM_PER_NODE, SLURM_MEM_PER_CPU x SLURM_CPUS_ON_NODE).
double available_memory_bytes();

/// This process and the workers that it starts later take at most so much.
void limit_memory(double limit_mb);

/// Throws InputError, with key and number, when what the vehicles' settings ask for exceeds the available memory.
void require_memory(const Scenario& scenario);

/// The same for one need of which the key is known.
void require_memory(const std::string& key, double bytes);

}  // namespace swiftlet::sim
