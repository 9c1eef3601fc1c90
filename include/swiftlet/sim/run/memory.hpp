// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::sim {

/// Memory [bytes] that this process may use in all: the machine's, or less by resource limits (as set by
/// limit_memory()), control groups (containers, version 1 or 2) or the Slurm job (SLURM_MEM_PER_NODE, SLURM_MEM_PER_CPU
/// x SLURM_CPUS_ON_NODE). Memory in use is not subtracted.
double available_memory_bytes();

/// Limits the data segment of this process, and of workers that it starts later, to limit_mib [MiB]; 0 or less: no
/// limit.
void limit_memory(double limit_mib);

/// Throws InputError when the vehicles' settings together need more than the available memory; the message names the
/// largest setting.
void require_memory(const Scenario& scenario);

/// Throws InputError when the setting `key` needs more than the available memory.
void require_memory(const std::string& key, double bytes);

}  // namespace swiftlet::sim
