// SPDX-License-Identifier: BSD-3-Clause
#include "fly_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <system_error>

#include "interrupt.hpp"
#include "progress.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/run/run_directory.hpp"

namespace swiftlet::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRunInterrupted = "interrupted; the unfinished run was removed";

void stop_if_interrupted() {
  if (StopSignals::requested()) throw Interrupted(kRunInterrupted);
}

void fly(sim::Simulation& simulation, bool quiet) {
  Progress progress(simulation.scenario().name, quiet);
  const auto start = std::chrono::steady_clock::now();
  while (!simulation.finished()) {
    simulation.tick();
    stop_if_interrupted();
    if (!progress.due()) continue;
    const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const double simulated_s = to_seconds(simulation.now());
    progress.update(simulated_s / simulation.scenario().duration_s,
                    fmt::format("{:.1f} of {:g} s, {:.1f} x real time", simulated_s, simulation.scenario().duration_s,
                                simulated_s / wall_s));
  }
}

}  // namespace

FlownRun fly_run(const sim::Scenario& scenario, const fs::path& out, int threads, bool quiet,
                 const std::function<void(sim::Simulation&, const fs::path&)>& prepare) {
  const StopSignals guard;
  sim::RunDirectory directory(out, sim::named_files(scenario));
  std::optional<StopDeadline> deadline(std::in_place, kRunInterrupted, [&directory] {
    std::error_code ignored;
    fs::remove_all(directory.path(), ignored);
  });

  const auto start = std::chrono::steady_clock::now();
  sim::Simulation simulation(scenario, threads);
  stop_if_interrupted();
  simulation.attach_recorders(directory.path());
  if (prepare) prepare(simulation, directory.path());
  const auto ready = std::chrono::steady_clock::now();
  fly(simulation, quiet);
  deadline.reset();  // writing the results must not be interrupted
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
