// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/run/memory.hpp"

#include <fmt/core.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "sim/run/control_groups.hpp"
#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kMebibyte = 1048576.0;  // [bytes]; settings and Slurm count in MiB

/// Soft limit of a resource of this process [bytes]; infinity: none.
double limit_of(int resource) {
  rlimit limit{};
  if (getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
    return std::numeric_limits<double>::infinity();
  return static_cast<double>(limit.rlim_cur);
}

/// Positive number in an environment variable; infinity when the variable has none.
double limit_of_variable(const char* name) {
  const char* text = std::getenv(name);
  const auto value = number_in<double>(text != nullptr ? text : "");
  return value && *value > 0.0 ? *value : std::numeric_limits<double>::infinity();
}

/// Memory of this process's Slurm job on this node [bytes], requested per node or per processor; infinity: none.
double limit_of_slurm() {
  const double node_mib = limit_of_variable("SLURM_MEM_PER_NODE");
  const double processors_mib = limit_of_variable("SLURM_MEM_PER_CPU") * limit_of_variable("SLURM_CPUS_ON_NODE");
  return std::min(node_mib, processors_mib) * kMebibyte;
}

/// Throws InputError for a setting that takes `bytes`; all_bytes: total of all settings.
[[noreturn]] void refuse(const std::string& key, double bytes, double all_bytes) {
  std::string message =
      fmt::format("{}: expected a setting that fits into {:.0f} MiB of memory, found one that takes {:.0f} MiB", key,
                  available_memory_bytes() / kMebibyte, bytes / kMebibyte);
  if (all_bytes > bytes) message += fmt::format(" of {:.0f} MiB in all", all_bytes / kMebibyte);
  throw InputError(message);
}

}  // namespace

double available_memory_bytes() {
  const double machine = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return std::min(
      {machine, limit_of(RLIMIT_DATA), limit_of(RLIMIT_AS), control_group_limits().memory_bytes, limit_of_slurm()});
}

void limit_memory(double limit_mib) {
  if (limit_mib <= 0.0) return;
  rlimit limit{};
  getrlimit(RLIMIT_DATA, &limit);
  limit.rlim_cur = std::min(limit.rlim_max, static_cast<rlim_t>(limit_mib * kMebibyte));
  setrlimit(RLIMIT_DATA, &limit);
}

void require_memory(const std::string& key, double bytes) {
  if (bytes > available_memory_bytes()) refuse(key, bytes, bytes);
}

void require_memory(const Scenario& scenario) {
  double all_bytes = 0.0;
  MemoryNeed largest;
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    for (const MemoryNeed& need : needs_of(scenario.vehicles[i].agent).memory) {
      all_bytes += need.bytes;
      if (need.bytes <= largest.bytes) continue;
      largest = {"vehicles[" + std::to_string(i) + "].agent." + need.key, need.bytes};
    }
  }
  if (all_bytes > available_memory_bytes()) refuse(largest.key, largest.bytes, all_bytes);
}

}  // namespace swiftlet::sim
