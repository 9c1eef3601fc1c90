// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "commands.hpp"
#include "progress.hpp"
#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/agent/stage_notifier.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/run/stage_clock.hpp"
#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/run/version.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::tools {
namespace {

struct BenchOptions {
  std::string csv;
  std::vector<std::string> cases;  // empty: all
  int threads = 0;
  bool quiet = false;
};

/// [s] Simulated time before the measurement. Excludes the allocations of the first ticks; larger values only take
/// longer.
constexpr double kWarmUp_s = 0.5;
/// [-] Number of vehicles of the crowd, as in the descriptions of its cases, and [m] their spacing, at which hovering
/// vehicles do not touch.
constexpr int kCrowdSize = 100;
constexpr double kCrowdSpacing_m = 3.0;

sim::Scenario read(const char* name) { return sim::load_scenario(std::string(name)); }

sim::Scenario read_without_recorders(const char* name) {
  sim::Scenario scenario = read(name);
  scenario.recorders.clear();
  scenario.snapshots.clear();
  return scenario;
}

// Replaces the vehicles of a scenario by copies of the first one on a square grid.
sim::Scenario with_copies(sim::Scenario scenario, int count, double spacing_m) {
  const sim::VehicleConfig model = scenario.vehicles.front();
  scenario.vehicles.clear();
  const int side = static_cast<int>(std::ceil(std::sqrt(count)));
  for (int i = 0; i < count; ++i) {
    sim::VehicleConfig vehicle = model;
    vehicle.name = fmt::format("uav{}", i + 1);
    vehicle.start.position_m +=
        Eigen::Vector3d(spacing_m * (i % side - side / 2), spacing_m * (i / side - side / 2), 0.0);
    scenario.vehicles.push_back(std::move(vehicle));
  }
  return scenario;
}

sim::Scenario crowd(double physics_step_s) {
  sim::Scenario scenario = with_copies(read("bench_crowd"), kCrowdSize, kCrowdSpacing_m);
  scenario.physics.step_s = physics_step_s;
  return scenario;
}

// Benchmark: a scenario whose simulation is timed after a warm-up.
struct Case {
  const char* name;
  const char* description;
  sim::Scenario (*make)();
  double simulated_s;  // measured after the warm-up
  // Whether the agents are timed by stage. Not for agents that only hover, because reading the clock would dominate.
  bool times_agents = false;
};

const Case kCases[] = {
    {"one_vehicle", "one X500, no LiDAR, 1 kHz physics", [] { return with_copies(read("bench_crowd"), 1, 1.0); }, 60.0},
    {"crowd_1khz", "100 X500, no LiDAR, 1 kHz physics", [] { return crowd(0.001); }, 10.0},
    {"crowd_250hz", "100 X500, no LiDAR, 250 Hz physics", [] { return crowd(0.004); }, 20.0},
    {"one_os1", "one OS1-128 at 10 Hz in a forest", [] { return read("bench_os1"); }, 5.0},
    {"ten_mid360", "10 X500 with a Mid-360 each in a forest", [] { return with_copies(read("bench_mid360"), 10, 4.0); },
     5.0},
    {"forest_patrol", "a patrol of four UAVs, of which one detects and tracks the others, without recorders",
     [] { return read_without_recorders("forest_patrol"); }, 5.0, true},
    {"guidance",
     "a UAV with an OS0-128 maps a forest, detects another UAV, plans for both and guides it (the quickstart), without "
     "recorders",
     [] { return read_without_recorders("forest_guidance"); }, 30.0, true},
    {"guided_gap", "a UAV guides another through a gap between two rooms, without recorders",
     [] { return read_without_recorders("guided_gap"); }, 30.0, true},
};

struct Result {
  const Case* bench_case;
  std::size_t num_triangles = 0;
  sim::RunSummary summary;
  // Share of each stage in the time of all agents; empty: agents are not timed
  std::vector<std::pair<std::string, double>> agent_shares;
};

std::vector<std::pair<std::string, double>> shares(std::vector<std::pair<std::string, double>> times_s) {
  double sum_s = 0.0;
  for (const auto& [stage, time_s] : times_s) sum_s += time_s;
  for (auto& [stage, time_s] : times_s) time_s /= sum_s;
  return times_s;
}

Result measure(const Case& bench_case, int threads, Progress& progress) {
  sim::Scenario scenario = bench_case.make();
  scenario.duration_s = kWarmUp_s + bench_case.simulated_s;
  scenario.metrics.stop_when_done = false;
  const auto begin = std::chrono::steady_clock::now();
  sim::Simulation simulation(std::move(scenario), threads);
  const double setup_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  while (to_seconds(simulation.now()) < kWarmUp_s) simulation.tick();
  const sim::RunSummary warm = simulation.summary();
  if (bench_case.times_agents) simulation.time_agents();
  const auto start = std::chrono::steady_clock::now();
  while (!simulation.finished()) {
    simulation.tick();
    if (progress.due())
      progress.update(to_seconds(simulation.now()) / (kWarmUp_s + bench_case.simulated_s), bench_case.name);
  }
  Result result{&bench_case, simulation.info().scene->num_triangles(), simulation.summary(), {}};
  result.summary.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.summary.simulated_s -= warm.simulated_s;
  result.summary.setup_wall_s = setup_s;
  for (std::size_t i = 0; i < warm.stage_wall_s.size(); ++i)
    result.summary.stage_wall_s[i].second -= warm.stage_wall_s[i].second;
  if (bench_case.times_agents) result.agent_shares = shares(simulation.agent_stage_s());
  return result;
}

void print(const Result& result) {
  const sim::RunSummary& s = result.summary;
  fmt::print("{:<14} {:>8.1f} x real time   {:016x}  {}\n", result.bench_case->name, s.real_time_factor(), s.state_hash,
             result.bench_case->description);
  fmt::print("{:<14} set-up {:.2f} s, {} triangles; ms per simulated second:", "", s.setup_wall_s,
             result.num_triangles);
  for (const auto& [stage, wall_s] : s.stage_wall_s) fmt::print(" {} {:.1f}", stage, 1e3 * wall_s / s.simulated_s);
  fmt::print("\n");
  if (!result.agent_shares.empty()) {
    fmt::print("{:<14} % of the agents' time:", "");
    for (const auto& [stage, share] : result.agent_shares) fmt::print(" {} {:.1f}", stage, 100.0 * share);
    fmt::print("\n");
  }
  std::fflush(stdout);
}

std::string row_of(const Result& result) {
  const sim::RunSummary& s = result.summary;
  std::string row = fmt::format("{},{},{},{},{},{:.4f},{:.3f},{:.4f},{:.3f},{:016x}", result.bench_case->name,
                                sim::version(), sim::git_revision(), s.threads, result.num_triangles, s.setup_wall_s,
                                s.simulated_s, s.wall_s, s.real_time_factor(), s.state_hash);
  for (const auto& [stage, wall_s] : s.stage_wall_s) row += fmt::format(",{:.4f}", wall_s);
  if (result.agent_shares.empty()) row.append(kAgentStageNames.size(), ',');
  for (const auto& [stage, share] : result.agent_shares) row += fmt::format(",{:.6f}", share);
  return row + "\n";
}

std::string header() {
  std::string row = "case,version,revision,threads,triangles,setup_s,simulated_s,wall_s,real_time_factor,state_hash";
  for (const char* stage : sim::kStageNames) row += fmt::format(",{}_wall_s", stage);
  for (const char* stage : kAgentStageNames) row += fmt::format(",agents_{}_share", stage);
  return row + "\n";
}

bool wanted(const char* name, const std::vector<std::string>& cases) {
  return cases.empty() || std::find(cases.begin(), cases.end(), name) != cases.end();
}

void check_names(const std::vector<std::string>& cases) {
  std::vector<std::string> known;
  for (const Case& c : kCases) known.emplace_back(c.name);
  for (const std::string& name : cases) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw sim::InputError(
        fmt::format("bench {}: expected one of {}{}", name, fmt::join(known, ", "), sim::did_you_mean(name, known)));
  }
}

void bench(const BenchOptions& options) {
  check_names(options.cases);
  if (!options.csv.empty()) sim::write_file(options.csv, "");  // reports an unwritable file before the measurement
  std::string csv = header();
  for (const Case& bench_case : kCases) {
    if (!wanted(bench_case.name, options.cases)) continue;
    Progress progress("bench", options.quiet);
    const Result result = measure(bench_case, options.threads, progress);
    progress.finish();
    if (!options.quiet) print(result);
    csv += row_of(result);
  }
  if (options.csv.empty()) return;
  sim::write_file(options.csv, csv);
  if (!options.quiet) fmt::print("\nwritten to {}\n", options.csv);
}

}  // namespace

void add_bench(CLI::App& app) {
  auto options = std::make_shared<BenchOptions>();
  Subcommand command(app, "bench", "Speed of each stage on this machine");
  command.option("cases", options->cases, "Only these cases");
  command.option("--csv", options->csv, "Also write the table to this file", {.value_name = "FILE"});
  command.option("--threads", options->threads, "Threads, 0: all", {.min = 0, .max = 1024});
  command.flag("-q,--quiet", options->quiet, "Print errors only");
  command.action([options] { bench(*options); });
}

}  // namespace swiftlet::tools
