// SPDX-License-Identifier: BSD-3-Clause
#include "fly_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "interrupt.hpp"
#include "progress.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/slam/slam.hpp"
#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/run/run_directory.hpp"

namespace swiftlet::tools {
namespace {

namespace fs = std::filesystem;

void stop_if_asked() {
  if (StopSignals::requested()) throw Interrupted("interrupted; the unfinished run was removed");
}

void fly(sim::Simulation& simulation, bool quiet) {
  Progress progress(simulation.scenario().name, quiet);
  const auto start = std::chrono::steady_clock::now();
  while (!simulation.finished()) {
    simulation.tick();
    stop_if_asked();
    if (!progress.due()) continue;
    const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const double simulated_s = to_seconds(simulation.now());
    progress.update(simulated_s / simulation.scenario().duration_s,
                    fmt::format("{:.1f} of {:g} s, {:.1f} x real time", simulated_s, simulation.scenario().duration_s,
                                simulated_s / wall_s));
  }
}

/// A map of an earlier flight that lies in the run directory would be lost with it, and nobody could fly the run again.
void keep_saved_maps(const sim::Scenario& scenario, const fs::path& out) {
  const fs::path directory = fs::weakly_canonical(out);
  for (const sim::VehicleConfig& vehicle : scenario.vehicles) {
    const auto* stack = dynamic_cast<const StackConfig*>(vehicle.agent.config.get());
    const auto* slam = stack != nullptr ? dynamic_cast<const SlamConfig*>(stack->localization.config.get()) : nullptr;
    if (slam == nullptr || slam->global.map.empty()) continue;
    const fs::path map = fs::weakly_canonical(slam->global.map);
    if (std::mismatch(directory.begin(), directory.end(), map.begin(), map.end()).first != directory.end()) continue;
    throw sim::InputError(vehicle.name + ": localization.global.map: expected a file outside of " + out.string() +
                          ", because the run replaces what is there, found " + slam->global.map);
  }
}

}  // namespace

FlownRun fly_run(const sim::Scenario& scenario, const fs::path& out, int threads, bool quiet,
                 const std::function<void(sim::Simulation&, const fs::path&)>& prepare) {
  const StopSignals guard;
  keep_saved_maps(scenario, out);
  sim::RunDirectory directory(out);

  const auto start = std::chrono::steady_clock::now();
  sim::Simulation simulation(scenario, threads);
  stop_if_asked();
  simulation.attach_recorders(directory.path());
  if (prepare) prepare(simulation, directory.path());
  const auto ready = std::chrono::steady_clock::now();
  fly(simulation, quiet);
  FlownRun flown;
  flown.written = simulation.finish();
  const auto done = std::chrono::steady_clock::now();
  std::sort(flown.written.begin(), flown.written.end());

  flown.summary = simulation.summary();
  flown.summary.setup_wall_s = std::chrono::duration<double>(ready - start).count();
  flown.summary.wall_s = std::chrono::duration<double>(done - ready).count();
  sim::write_file(directory.path() / "scenario.yaml", sim::write_scenario(scenario));
  sim::write_file(directory.path() / "summary.json", sim::to_json(flown.summary));
  directory.commit();
  return flown;
}

}  // namespace swiftlet::tools
