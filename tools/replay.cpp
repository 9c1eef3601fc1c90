// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "commands.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/replay/replay.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/run/version.hpp"

namespace swiftlet::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPageInterrupted = "interrupted; the unfinished page was removed";

struct ReplayOptions {
  std::string run;
  std::string out;
  std::optional<double> scan_rate_hz, scan_budget_kBps;
  int threads = 0;
  bool quiet = false;
};

// Configuration of the run's own replay recorder, if it has one, with the given options.
sim::ReplayConfig config_of(const sim::Scenario& scenario, const ReplayOptions& options) {
  sim::ReplayConfig config;
  for (const Module& recorder : scenario.recorders) {
    if (const auto* own = dynamic_cast<const sim::ReplayConfig*>(recorder.config.get())) config = *own;
  }
  config.scan_rate_hz = options.scan_rate_hz.value_or(config.scan_rate_hz);
  config.scan_budget_kBps = options.scan_budget_kBps.value_or(config.scan_budget_kBps);
  return config;
}

// Repeats the flight of the resolved scenario, which gives the same bits: the page shows the run itself or is not
// written.
void replay(const ReplayOptions& options) {
  const fs::path run(options.run);
  if (!fs::exists(run / "scenario.yaml") || !fs::exists(run / "summary.json")) {
    throw sim::InputError(options.run +
                          ": expected the directory of a finished run (with scenario.yaml and summary.json)");
  }
  const std::string summary = sim::read_whole_file(run / "summary.json");
  sim::Scenario scenario = sim::load_scenario(run / "scenario.yaml");
  const sim::ReplayConfig config = config_of(scenario, options);
  scenario.recorders.clear();
  scenario.snapshots.clear();
  const fs::path out = fs::absolute(options.out.empty() ? run / "replay.html" : fs::path(options.out));
  if (fs::is_directory(out)) throw sim::InputError(options.out + ": expected the name of a file, found a directory");
  if (!fs::is_directory(out.parent_path()))
    throw sim::InputError(options.out + ": expected a file in a directory that is there");

  const StopSignals guard;
  std::optional<StopDeadline> deadline(std::in_place, kPageInterrupted, [&out] {
    std::error_code ignored;
    fs::remove(out.string() + ".part", ignored);
  });
  sim::Simulation simulation(scenario, options.threads);
  simulation.attach(sim::make_replay_recorder(config, out), out.parent_path());
  {
    Progress progress("replay", options.quiet);
    while (!simulation.finished()) {
      simulation.tick();
      if (StopSignals::requested()) throw Interrupted(kPageInterrupted);
      if (!progress.due()) continue;
      const double now_s = to_seconds(simulation.now());
      progress.update(now_s / scenario.duration_s, fmt::format("{:.1f} of {:g} s", now_s, scenario.duration_s));
    }
  }
  if (summary.find('"' + sim::hex64(simulation.state_hash()) + '"') == std::string::npos) {
    throw sim::InputError(
        fmt::format("{}: expected a run that this program ({}, {}) reproduces, found another state hash than {}; "
                    "replay it with the "
                    "program that flew it (its version is in summary.json)",
                    options.run, sim::version(), sim::git_revision(), sim::hex64(simulation.state_hash())));
  }
  deadline.reset();
  simulation.finish();
  if (!options.quiet) fmt::print("{}\n", options.out.empty() ? (run / "replay.html").string() : options.out);
}

}  // namespace

void add_replay(CLI::App& app) {
  auto options = std::make_shared<ReplayOptions>();
  Subcommand command(app, "replay", "Make a page for a browser of a finished run by flying it again, bit for bit");
  command.option("run", options->run, "Directory of a finished run", {.value_name = "RUN_DIR", .required = true});
  command.option("-o,--out", options->out, "Page to write (default: RUN_DIR/replay.html)", {.value_name = "FILE.html"});
  command.option("--scan-rate", options->scan_rate_hz, "Rate of each LiDAR's scans [Hz], 0: none (default: 2)",
                 {.value_name = "HZ", .min = 0.0, .max = 1000.0});
  command.option("--scan-budget", options->scan_budget_kBps,
                 "Data rate to which all scans together are thinned (default: 60)",
                 {.value_name = "KB", .min = 1.0, .max = 1e5});
  command.option("--threads", options->threads, "Threads, 0: all", {.min = 0, .max = 1024});
  command.flag("-q,--quiet", options->quiet, "Print errors only");
  command.action([options] { replay(*options); });
}

}  // namespace swiftlet::tools
