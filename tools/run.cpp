// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "commands.hpp"
#include "fly_run.hpp"
#include "progress.hpp"
#include "scenario_options.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/replay/live_server.hpp"
#include "swiftlet/sim/run/memory.hpp"
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

// Prints one line for each folder: a run may write thousands of scans.
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
  std::unique_ptr<sim::LiveServer> server;
  const FlownRun flown = fly_run(scenario, out, options.threads, options.quiet,
                                 [&](sim::Simulation& simulation, const fs::path& directory) {
                                   if (!options.view) return;
                                   server = std::make_unique<sim::LiveServer>();
                                   simulation.attach(sim::make_live_recorder({}, *server), directory);
                                   fmt::print("view the run at {}\n", server->address());
                                   std::fflush(stdout);
                                 });
  if (server) server->finish();
  if (!options.quiet) {
    fmt::print("{}", sim::to_text(flown.summary));
    print_paths(out, flown.written);
    if (has_replay(scenario)) fmt::print("\nto view it, open {}\n", fs::absolute(out / "replay.html").string());
  }
  const std::string crashed = crashed_vehicles(flown.summary);
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
                 "Memory limit of the run [MiB], 0: that of the machine; larger scenarios are rejected", {.min = 0});
  command.flag("--replay", options->replay, "Write the run as a page for a browser as well (replay.html)");
  command.flag("--view", options->view, "Serve that page during the run, to this machine only");
  command.flag("--fail-on-crash", options->fail_on_crash,
               "Exit with status 1 when a vehicle has crashed; without it a finished run exits with 0");
  command.flag("-q,--quiet", options->quiet, "Print errors only");
  command.action([options] { run(*options); });
}

}  // namespace swiftlet::tools
