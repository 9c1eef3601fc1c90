// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <memory>
#include <optional>

#include "commands.hpp"
#include "interrupt.hpp"
#include "plugin_options.hpp"
#include "progress.hpp"
#include "scenario_options.hpp"
#include "swiftlet/sim/dataset/generate.hpp"
#include "swiftlet/sim/dataset/verify.hpp"
#include "swiftlet/sim/run/processors.hpp"

namespace swiftlet::tools {
namespace {

struct DatasetOptions {
  bool allow_plugins = false;
  std::string file, out;
  std::vector<std::string> set;
  int jobs = 0;
  bool resume = false;
  bool quiet = false;
};

struct VerifyCommand {
  std::string directory;
  int frames = 3;
  std::optional<std::uint64_t> seed;
  bool quiet = false;
};

void print_outside(const std::string& share) {
  if (!share.empty()) fmt::print("{}\n", share);
}

void generate(const DatasetOptions& options) {
  const sim::DatasetPlan plan = sim::plan_dataset(sim::load_dataset(options.file, parse_assignments(options.set)));
  const StopSignals guard;  // finished sequences survive an interrupt
  Progress progress(plan.config.name, options.quiet);
  sim::GenerateOptions generation;
  generation.directory = options.out;
  generation.jobs = options.jobs > 0 ? options.jobs : sim::available_processors();
  generation.resume = options.resume;
  generation.canceled = [] { return StopSignals::requested(); };
  generation.progress = [&](int done, int all, const std::string&) {
    if (progress.due()) progress.update(static_cast<double>(done) / all, fmt::format("{} of {} flights", done, all));
  };
  const sim::GenerateReport report = sim::generate_dataset(plan, generation);
  progress.finish();
  if (report.canceled) {
    throw Interrupted(fmt::format("interrupted; {} of {} flights are finished and kept; continue with --resume",
                                  report.flights_done, report.flights_all));
  }
  if (options.quiet) return;
  sim::SequenceStatistics sum;
  for (const sim::SequenceInfo& info : report.sequences) sum.add(info.statistics);
  fmt::print("{}: {} flights, {} sequences, {} frames, {} points in {}\n", plan.config.name, report.flights_all,
             report.sequences.size(), sum.frames, sum.points, duration_text(report.wall_s));
  print_outside(sim::poses_outside(report.sequences));
  const sim::FlightTiming& timing = report.timing;
  if (timing.simulate_s > 0.0) {
    fmt::print("worlds and paths {}, simulation {}, recording {} and {} beside the simulation\n",
               duration_text(timing.prepare_s), duration_text(timing.simulate_s), duration_text(timing.record_s),
               duration_text(timing.beside_s));
  }
  fmt::print("\n{}\n", bold("written to " + options.out));
  fmt::print("  {:<24} data card: statistics, histograms, pictures\n", "README.md");
  fmt::print("  {:<24} version, seeds, hash of every file\n", "manifest.json");
  fmt::print("  {:<24} classes, colors and splits for readers of SemanticKITTI\n", "semantic-kitti.yaml");
  fmt::print("  {:<24} one directory per LiDAR and flight\n", "sequences/NN/");
}

void verify(const VerifyCommand& command) {
  constexpr const char* kInterrupted = "interrupted before everything was compared";
  const StopSignals guard;
  const StopDeadline deadline(kInterrupted);
  Progress progress("verify", command.quiet);
  sim::VerifyOptions options;
  options.frames = command.frames;
  options.seed = command.seed.value_or(0);
  options.canceled = [] { return StopSignals::requested(); };
  options.progress = [&](double done, const std::string& note) {
    if (progress.due()) progress.update(done, note);
  };
  const sim::VerifyReport report = sim::verify_dataset(command.directory, options);
  progress.finish();
  if (StopSignals::requested()) throw Interrupted(kInterrupted);
  for (const std::string& problem : report.problems) fmt::print(stderr, "{}\n", problem);
  if (!report.ok()) {
    throw std::runtime_error(fmt::format("{}: {} problem{}", command.directory, report.problems.size(),
                                         report.problems.size() == 1 ? "" : "s"));
  }
  if (command.quiet) return;
  fmt::print("{}: {} files as in the manifest, {} frames laid out well, {} simulated again bit for bit\n",
             command.directory, report.files, report.frames, report.resimulated);
  print_outside(report.poses_outside);
}

}  // namespace

void add_dataset(CLI::App& app) {
  auto options = std::make_shared<DatasetOptions>();
  Subcommand command(app, "dataset", "Write a labeled dataset, or verify one");
  command.option("dataset", options->file, "Dataset file, or the name of one of Swiftlet's",
                 {.value_name = "DATASET.yaml"});
  command.option("--out", options->out, "Directory to write", {.value_name = "DIR"});
  command.option("--jobs", options->jobs, "Concurrent flights, each in its own process (default: one per processor)",
                 {.min = 0, .max = 1024});
  command.flag("--resume", options->resume, "Continue an interrupted generation");
  command.option("--set", options->set, "Override any key: --set splits[0].flights=2 (may be repeated)",
                 {.value_name = "KEY=VALUE", .repeated = true});
  add_allow_plugins(command, options->allow_plugins);
  command.flag("-q,--quiet", options->quiet, "Print errors only");
  command.action([options] {
    if (options->file.empty()) throw sim::InputError("dataset: expected a dataset file, found none");
    if (options->out.empty()) throw sim::InputError("dataset: expected --out DIR, found none");
    if (options->allow_plugins) allow_plugins();
    generate(*options);
  });

  auto check = std::make_shared<VerifyCommand>();
  Subcommand verification = command.subcommand("verify", "Check layout, hashes, and random frames by simulation");
  verification.option("directory", check->directory, "Dataset", {.value_name = "DIR", .required = true});
  verification.option("--frames", check->frames, "Frames to simulate again", {.min = 0, .max = 1000000});
  verification.option("--seed", check->seed, "Seed of their choice (default: 0)", {.value_name = "N"});
  verification.flag("-q,--quiet", check->quiet, "Print errors only");
  verification.action([check] { verify(*check); });
}

}  // namespace swiftlet::tools
