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
  std::vector<std::filesystem::path> written;  ///< by the recorders, within the run directory, sorted
};

/// Flies a scenario into a run directory: what its recorders write, the resolved scenario, the summary. Shows progress
/// unless it is to be quiet. Ctrl-C ends it after the present tick by Interrupted, and the program half a second later
/// when neither a tick nor the world is complete by then; nothing that looks finished is left behind.
/// @param out      the run directory; an earlier run there is replaced
/// @param prepare  called before the first tick, with the directory that is written to
FlownRun fly_run(const sim::Scenario& scenario, const std::filesystem::path& out, int threads, bool quiet,
                 const std::function<void(sim::Simulation&, const std::filesystem::path&)>& prepare = {});

}  // namespace swiftlet::tools
