// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "commands.hpp"
#include "experiments/experiment.hpp"
#include "progress.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/run/processors.hpp"

namespace swiftlet::tools {
namespace {

namespace fs = std::filesystem;

struct ReproduceOptions {
  std::vector<std::string> names;
  std::string out = "reproduce";
  int jobs = 0;
  std::optional<int> repetitions;
  bool quick = false;
  bool resume = false;
  bool list = false;
  bool quiet = false;
};

void print_list() {
  for (const ExperimentType& type : experiment_types()) {
    fmt::print("{:<22} {}\n", type.name, type.doc);
  }
}

void print_rows(const Experiment& experiment) {
  for (const ResultRow& row : experiment.rows()) {
    fmt::print("  {:<58} {:>14} {:>14} {:>16}  {}{}\n", row.what, row.published, row.ours, tolerance_of(row),
               verdict_of(row), row.note.empty() ? "" : ": " + row.note);
  }
}

int run_one(const ExperimentType& type, const ReproduceOptions& options) {
  const fs::path directory = fs::path(options.out) / type.name;
  fs::create_directories(directory);
  Progress progress(type.name, options.quiet);
  ExperimentOptions handed;
  handed.name = type.name;
  handed.directory = directory;
  handed.jobs = options.jobs > 0 ? options.jobs : sim::available_processors();
  handed.repetitions = options.repetitions;
  handed.quick = options.quick;
  handed.resume = options.resume;
  handed.progress = [&](double done, const std::string& note) {
    if (progress.due()) progress.update(done, note);
  };

  const auto start = std::chrono::steady_clock::now();
  Experiment experiment(handed);
  type.run(experiment);
  progress.finish();
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  sim::write_file(directory / "result.md", to_markdown(type, experiment));
  sim::write_file(directory / "result.json", to_json(type, experiment));
  if (!options.quiet) {
    fmt::print("{}{} in {}, written to {}\n", bold(type.name), options.quick ? ", quick version" : "",
               duration_text(wall_s), directory.string());
    fmt::print("  {:<58} {:>14} {:>14} {:>16}  {}\n", "", "published", "ours", "tolerance", "verdict");
    print_rows(experiment);
  }
  int differing = 0;
  for (const ResultRow& row : experiment.rows()) differing += row.verdict == Verdict::kDiffers ? 1 : 0;
  return differing;
}

void reproduce(const ReproduceOptions& options) {
  if (options.list) {
    print_list();
    return;
  }
  std::vector<const ExperimentType*> chosen;
  for (const std::string& name : options.names) chosen.push_back(&experiment_type(name));
  if (chosen.empty()) {
    for (const ExperimentType& type : experiment_types()) chosen.push_back(&type);
  }
  int differing = 0;
  for (const ExperimentType* type : chosen) differing += run_one(*type, options);
  if (!options.quiet && differing > 0)
    fmt::print("{} result{} from what was published\n", differing, differing == 1 ? " differs" : "s differ");
}

}  // namespace

static void add_reproduce(CLI::App& app) {
  auto options = std::make_shared<ReproduceOptions>();
  Subcommand command(app, "reproduce",
                     "Regenerate published experiments: data, plots and a table of published against ours");
  command.option("names", options->names, "Experiments; none: all of them", {.value_name = "NAME"});
  command.option("--out", options->out, "Folder of the results, one folder each in it", {.value_name = "DIR"});
  command.option("--jobs", options->jobs, "Runs at a time, 0: as many as processors; changes no result",
                 {.min = 0, .max = 1024});
  command.option("--repetitions", options->repetitions, "Runs a case instead of the experiment's own number",
                 {.min = 1, .max = 1e6});
  command.flag("--quick", options->quick, "A small version of each: fewer samples and seeds");
  command.flag("--resume", options->resume, "Do not fly again what an earlier attempt finished (flights.jsonl)");
  command.flag("--list", options->list, "Only list the experiments");
  command.flag("-q,--quiet", options->quiet, "Print errors only");
  command.action([options] { reproduce(*options); });
}

}  // namespace swiftlet::tools

/// The experiments of the literature as a program of its own (tools/experiments), apart from `swiftlet`.
int main(int argc, char** argv) { return swiftlet::tools::run(argc, argv, {swiftlet::tools::add_reproduce}); }
