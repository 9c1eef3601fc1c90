// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <limits>

namespace swiftlet::sim {

/// Limits by the control groups of this process; infinity without limit.
struct ControlGroupLimits {
  double processors = std::numeric_limits<double>::infinity();  ///< quota of processor time over its period
  double memory_bytes = std::numeric_limits<double>::infinity();
};

/// Reads the group of this process and its parents, of version 2 and of version 1, and returns the least limits. In a
/// container the path in /proc/self/cgroup may be that of the host; missing groups set no limit.
/// @param root  folder that contains proc and sys
ControlGroupLimits control_group_limits(const std::filesystem::path& root = "/");

}  // namespace swiftlet::sim
