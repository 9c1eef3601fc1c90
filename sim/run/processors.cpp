// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/run/processors.hpp"

#include <omp.h>
#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>
#include <thread>

#include "sim/run/control_groups.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

std::string_view variable(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? std::string_view() : text;
}

/// 0 when the affinity mask is larger than cpu_set_t and cannot be read.
int in_affinity_mask() {
  cpu_set_t set;
  return ::sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 0;
}

}  // namespace

int available_processors() {
  int count = in_affinity_mask();
  if (count < 1) count = static_cast<int>(std::thread::hardware_concurrency());
  const double quota = std::ceil(control_group_limits().processors);
  if (quota < count) count = static_cast<int>(quota);
  for (const char* name : {"SLURM_CPUS_PER_TASK", "SLURM_CPUS_ON_NODE"}) {
    if (const auto given = number_in<int>(variable(name)); given && *given > 0) count = std::min(count, *given);
  }
  return std::max(count, 1);
}

int default_threads() {
  const int threads = omp_get_max_threads();
  if (threads > kMaxThreads) {
    throw InputError("OMP_NUM_THREADS: expected a whole number in [1, " + std::to_string(kMaxThreads) + "], found " +
                     std::to_string(threads));
  }
  return variable("OMP_NUM_THREADS").empty() ? std::min(threads, available_processors()) : threads;
}

void limit_openmp() { omp_set_num_threads(default_threads()); }

}  // namespace swiftlet::sim
