// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

namespace swiftlet::sim {

/// Writes report.html into a run directory and returns its path. The page shows outcome, metrics, flown paths, time
/// series, events, snapshots and the wall time of each stage. Time series come from recorded CSV states, otherwise from
/// TUM trajectories. Throws InputError when it is no run directory.
std::vector<std::filesystem::path> write_run_report(const std::filesystem::path& directory);

}  // namespace swiftlet::sim
