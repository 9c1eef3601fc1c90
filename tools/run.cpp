// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "commands.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "scenario_options.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/replay/live_server.hpp"
#include "swiftlet/sim/run/memory.hpp"
#include "swiftlet/sim/run/run_directory.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/run/summary.hpp"

namespace swiftlet::tools {
namespace {

namespace fs = std::filesystem;

struct RunOptions {
  ScenarioOptions scenario;
  std::string out;
  int threads = 0;
  double memory_limit_mb = 0.0;
  bool replay = false;
  bool view = false;
  bool fail_on_crash = false;
  bool quiet = false;
};

std::string crashed_vehicles(const sim::RunSummary& summary) {
  std::string names;
  for (const sim::MetricRow& row : summary.metrics.rows()) {
    if (row.name == "outcome" && row.text == "crashed" && !row.vehicle.empty())
      names += (names.empty() ? "" : ", ") + row.vehicle;
  }
  return names;
}

// Ctrl-C ends the run after the present tick; nothing that looks finished is left behind.
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

// One line for a whole folder: a run may write thousands of scans.
void print_paths(const fs::path& directory, const std::vector<fs::path>& written) {
  std::vector<std::pair<fs::path, int>> folders;
  for (const fs::path& path : written) {
    const fs::path folder = path.parent_path();
    if (!folders.empty() && folders.back().first == folder) {
      ++folders.back().second;
    } else {
      folders.emplace_back(folder, 1);
    }
  }
  fmt::print("\n{}\n", bold("written to " + directory.string()));
  fmt::print("  {:<40} outcome, metrics, hash, timing\n", "summary.json");
  fmt::print("  {:<40} the complete scenario: running it gives the same hash\n", "scenario.yaml");
  for (const auto& [folder, count] : folders) {
    if (folder.empty()) {
      for (const fs::path& path : written) {
        if (path.parent_path().empty()) fmt::print("  {}\n", path.string());
      }
    } else {
      fmt::print("  {:<40} {} file{}\n", folder.string() + "/", count, count == 1 ? "" : "s");
    }
  }
}

bool has_replay(const sim::Scenario& scenario) {
  return std::ranges::any_of(scenario.recorders, [](const Module& recorder) { return recorder.type == "replay"; });
}

void run(const RunOptions& options) {
  sim::limit_memory(options.memory_limit_mb);
  sim::Scenario scenario = options.scenario.load();
  if (options.replay && !has_replay(scenario)) {
    scenario.recorders.emplace_back(sim::recorder_module_types(), "replay");
  }
  const fs::path out = options.out.empty() ? fs::path("runs") / fmt::format("{}-{}", scenario.name, scenario.seed)
                                           : fs::path(options.out);
  const StopSignals guard;
  sim::RunDirectory directory(out);

  const auto start = std::chrono::steady_clock::now();
  sim::Simulation simulation(scenario, options.threads);
  stop_if_asked();
  simulation.attach_recorders(directory.path());
  std::unique_ptr<sim::LiveServer> server;
  if (options.view) {
    server = std::make_unique<sim::LiveServer>();
    simulation.attach(sim::make_live_recorder({}, *server), directory.path());
    fmt::print("view the run at {}\n", server->address());
    std::fflush(stdout);
  }
  const auto ready = std::chrono::steady_clock::now();
  fly(simulation, options.quiet);
  std::vector<fs::path> written = simulation.finish();
  const auto done = std::chrono::steady_clock::now();
  std::sort(written.begin(), written.end());

  sim::RunSummary summary = simulation.summary();
  summary.setup_wall_s = std::chrono::duration<double>(ready - start).count();
  summary.wall_s = std::chrono::duration<double>(done - ready).count();
  sim::write_file(directory.path() / "scenario.yaml", sim::write_scenario(scenario));
  sim::write_file(directory.path() / "summary.json", sim::to_json(summary));
  directory.commit();
  if (server) server->finish();
  if (!options.quiet) {
    fmt::print("{}", sim::to_text(summary));
    print_paths(out, written);
    if (has_replay(scenario)) fmt::print("\nto look at it, open {}\n", fs::absolute(out / "replay.html").string());
  }
  const std::string crashed = crashed_vehicles(summary);
  if (options.fail_on_crash && !crashed.empty()) {
    std::fflush(stdout);
    throw std::runtime_error("crashed: " + crashed + "; the run is in " + out.string());
  }
}

}  // namespace

void add_run(CLI::App& app) {
  auto options = std::make_shared<RunOptions>();
  Subcommand command(app, "run", "Fly one scenario");
  options->scenario.add_to(command);
  command.option("--out", options->out, "Run directory (default: runs/NAME-SEED); an earlier run there is replaced",
                 {.value_name = "DIR"});
  command.option("--threads", options->threads, "Threads for sensors and agents, 0: all; changes no result",
                 {.min = 0, .max = 1024});
  command.option("--memory-limit", options->memory_limit_mb,
                 "MiB that the run may take, 0: what the machine has; what would take more is refused", {.min = 0});
  command.flag("--replay", options->replay, "Write the run as a page for a browser as well (replay.html)");
  command.flag("--view", options->view, "Serve that page while the run goes on, to this machine only");
  command.flag("--fail-on-crash", options->fail_on_crash,
               "Exit with status 1 when a vehicle has crashed; without it a finished run exits with 0");
  command.flag("-q,--quiet", options->quiet, "Print errors only");
  command.action([options] { run(*options); });
}

}  // namespace swiftlet::tools
