// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/run/summary.hpp"

namespace swiftlet::tools {

struct FlownRun {
  sim::RunSummary summary;
  std::vector<std::filesystem::path> written;  ///< files of the recorders, relative to the run directory, sorted
};

/// Flies a scenario into a run directory with the files of its recorders, the resolved scenario and the summary. Shows
/// progress unless quiet. Ctrl-C throws Interrupted after the current tick; if neither a tick nor the world is complete
/// half a second later, it ends the program. No incomplete run directory appears under its final name.
/// @param out      the run directory; an earlier run there is replaced
/// @param prepare  called before the first tick, with the directory being written
FlownRun fly_run(const sim::Scenario& scenario, const std::filesystem::path& out, int threads, bool quiet,
                 const std::function<void(sim::Simulation&, const std::filesystem::path&)>& prepare = {});

}  // namespace swiftlet::tools
