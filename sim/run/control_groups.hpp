// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <limits>

namespace swiftlet::sim {

/// What the control groups of this process allow; infinity where none sets a limit.
struct ControlGroupLimits {
  double processors = std::numeric_limits<double>::infinity();  ///< quota of processor time over its period
  double memory_bytes = std::numeric_limits<double>::infinity();
};

/// Reads the group of this process and the groups above it, of version 2 and of version 1, and returns the least
/// limits. In a container the path in /proc/self/cgroup may be that of the host; groups that are absent set no limit.
/// @param root  folder that holds proc and sys
ControlGroupLimits control_group_limits(const std::filesystem::path& root = "/");

}  // namespace swiftlet::sim
