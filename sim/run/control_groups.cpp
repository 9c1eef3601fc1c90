// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/control_groups.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

/// The words of a file; empty when it cannot be read.
std::vector<std::string> words_of(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istream_iterator<std::string>(stream), {}};
}

/// A limit above 0; "max" and -1 mean no limit.
std::optional<double> limit(const std::vector<std::string>& words, std::size_t i) {
  const auto value = i < words.size() ? number_in<double>(words[i]) : std::nullopt;
  return value && *value > 0.0 ? value : std::nullopt;
}

void apply(double& least, std::optional<double> value) {
  if (value) least = std::min(least, *value);
}

/// cpu.max holds "QUOTA PERIOD" or "max PERIOD" (version 2), cpu.cfs_quota_us and cpu.cfs_period_us one number each.
void apply_group(const fs::path& folder, ControlGroupLimits& limits) {
  const auto max = words_of(folder / "cpu.max");
  auto quota = limit(max, 0), period = limit(max, 1);
  if (!quota) {
    quota = limit(words_of(folder / "cpu.cfs_quota_us"), 0);
    period = limit(words_of(folder / "cpu.cfs_period_us"), 0);
  }
  if (quota && period) apply(limits.processors, *quota / *period);
  for (const char* file : {"memory.max", "memory.limit_in_bytes"})
    apply(limits.memory_bytes, limit(words_of(folder / file), 0));
}

/// Applies the group `path` below `mount` and all its parents up to the mount itself.
void apply_groups(const fs::path& mount, std::string_view path, ControlGroupLimits& limits) {
  fs::path group = fs::path(path).relative_path().lexically_normal();
  if (group.empty() || *group.begin() == "..") group.clear();
  for (;; group = group.parent_path()) {
    apply_group(mount / group, limits);
    if (group.empty()) return;
  }
}

}  // namespace

ControlGroupLimits control_group_limits(const fs::path& root) {
  ControlGroupLimits limits;
  const fs::path mount = root / "sys/fs/cgroup";
  std::ifstream groups(root / "proc/self/cgroup");
  // "0::/path" in version 2, "4:cpu,cpuacct:/path" in version 1.
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1), path = line.substr(second + 1);
    apply_groups(mount / (controllers.empty() ? "." : controllers), path, limits);
    std::istringstream each(controllers);  // "cpu,cpuacct" is mounted under that name or under one of the two
    for (std::string controller; std::getline(each, controller, ',');) apply_groups(mount / controller, path, limits);
  }
  return limits;
}

}  // namespace swiftlet::sim
