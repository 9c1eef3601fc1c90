// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "fly_run.hpp"
#include "interrupt.hpp"
#include "plugin_options.hpp"
#include "progress.hpp"
#include "scenario_options.hpp"
#include "swiftlet/sim/batch/episode_list.hpp"
#include "swiftlet/sim/batch/merge.hpp"
#include "swiftlet/sim/batch/run_batch.hpp"
#include "swiftlet/sim/batch/shell.hpp"
#include "swiftlet/sim/batch/slurm.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/report/batch_report.hpp"
#include "swiftlet/sim/run/processors.hpp"

namespace swiftlet::tools {
namespace {

namespace fs = std::filesystem;

struct BatchArguments {
  bool allow_plugins = false;
  std::string file;
  std::string out;
  std::vector<std::string> set;
  int jobs = 0;
  std::string shard;
  std::string episodes;
  double memory_limit_mb = 0.0;
  bool resume = false;
  bool retry = false;
  bool plan = false;
  bool slurm = false;
  bool submit = false;
  int replays = 0;
  bool quiet = false;
};

struct MergeArguments {
  std::string out;
  std::vector<std::string> sources;
  bool quiet = false;
};

fs::path out_of(const BatchArguments& arguments, const sim::BatchPlan& plan) {
  return arguments.out.empty() ? fs::path("batches") / plan.config().name : fs::path(arguments.out);
}

sim::Shard shard_of(const BatchArguments& arguments) {
  return arguments.shard.empty() ? sim::shard_of_environment(sim::system_environment())
                                 : sim::parse_shard(arguments.shard);
}

void show_plan(const sim::BatchPlan& plan) {
  fmt::print("{}: {} episodes = {} point{} x {} seed{} x {} variant{}\n", plan.config().name, plan.num_episodes(),
             plan.points().size(), plan.points().size() == 1 ? "" : "s",
             plan.config().seeds.pairing == sim::SeedsConfig::Pairing::kZip ? 1 : plan.seeds().size(),
             plan.seeds().size() == 1 ? "" : "s", plan.config().variants.size(),
             plan.config().variants.size() == 1 ? "" : "s");
  for (std::uint64_t id = 0; id < plan.num_episodes(); ++id) {
    fmt::print("{:6}  {}\n", id, plan.command_of(plan.episode(id)));
  }
}

void make_cluster_job(const BatchArguments& arguments, const sim::BatchPlan& plan) {
  const fs::path out = out_of(arguments, plan);
  const sim::SlurmScripts scripts = sim::make_slurm_scripts(plan, out, fs::read_symlink("/proc/self/exe"));
  const sim::SlurmFiles files = sim::write_slurm_scripts(scripts, out);
  if (!arguments.quiet) {
    fmt::print("{} episodes in {} task{} of {}, at most {} min each\n  {}\n  {}\n", plan.num_episodes(),
               scripts.num_tasks, scripts.num_tasks == 1 ? "" : "s", scripts.episodes_per_task, scripts.time_limit_min,
               files.array.string(), files.merge.string());
  }
  if (arguments.submit) {
    const sim::SlurmJobs jobs = sim::submit(files);
    if (!arguments.quiet) fmt::print("submitted: array {}, merge job {} after its end\n", jobs.array, jobs.merge);
  } else if (!arguments.quiet) {
    fmt::print(
        "submit them with --submit, or with: job=$(sbatch --parsable {}) && sbatch --dependency=afterany:$job {}\n",
        files.array.string(), files.merge.string());
  }
}

std::string note_of(const sim::BatchProgress& p, double elapsed_s) {
  const double per_minute = elapsed_s > 0.0 ? 60.0 * static_cast<double>(p.flown) / elapsed_s : 0.0;
  return fmt::format("{} of {} done, {} failed, {} running, {:.1f} episodes/min", p.done, p.total, p.failed, p.running,
                     per_minute);
}

void print_outcome(const sim::BatchOutcome& outcome, const fs::path& out, double elapsed_s) {
  fmt::print("{} in {}\n", note_of(outcome.progress, elapsed_s), duration_text(elapsed_s));
  fmt::print("  {:<40} every episode and metric\n", outcome.database.string());
  if (outcome.database.parent_path() == out) {
    fmt::print("  {:<40} one row per episode\n  {:<40} one row per metric\n", (out / "episodes.csv").string(),
               (out / "metrics.csv").string());
  }
}

// Lists unfinished episodes with the commands that repeat them; any of them makes the exit status 1.
void print_failures(const fs::path& database) {
  constexpr int kShown = 5;
  const sim::ResultStore store(database, sim::ResultStore::Mode::kRead);
  int count = 0;
  for (const sim::EpisodeRow& row : store.episodes(false)) {
    if (row.done() || ++count > kShown) continue;
    fmt::print(stderr, "swiftlet: episode {} (seed {}): {}: {}\n  repeat with: {}\n", row.id, row.seed, row.status,
               row.message, row.command);
  }
  if (count == 0) return;
  throw std::runtime_error(fmt::format("{} episode{} did not end as {} should; all of them: view failures in {}", count,
                                       count == 1 ? "" : "s", count == 1 ? "it" : "they", database.string()));
}

// Repeats the worst episodes, recording their replays for the report.
void write_replays(const BatchArguments& arguments, const sim::BatchPlan& plan, const fs::path& out, int threads) {
  const sim::BatchTable table = sim::read_batch_table({out / "results.sqlite", sim::ResultStore::Mode::kRead});
  for (const sim::EpisodeRow& row : sim::worst_episodes(table, static_cast<std::size_t>(arguments.replays))) {
    const fs::path directory = out / sim::replay_of_episode(row.id);
    if (!sim::has_replay(out, row)) {
      sim::make_inner_directory(directory.parent_path());
      sim::Scenario scenario = plan.scenario_of(plan.episode(row.id));
      scenario.snapshots.clear();
      scenario.recorders.clear();
      scenario.recorders.emplace_back(sim::recorder_module_types(), "replay");
      fly_run(scenario, directory, threads, arguments.quiet);
    }
    if (!arguments.quiet) fmt::print("  {:<40} episode {} plays there\n", (directory / "replay.html").string(), row.id);
  }
}

void fly(const BatchArguments& arguments, const sim::BatchPlan& plan) {
  sim::BatchOptions options;
  options.out = out_of(arguments, plan);
  options.jobs = arguments.jobs > 0 ? arguments.jobs : sim::available_processors();
  options.shard = shard_of(arguments);
  if (!arguments.episodes.empty()) options.episodes = sim::parse_episodes(arguments.episodes, plan.num_episodes());
  options.resume = arguments.resume || arguments.retry;
  options.retry = arguments.retry;
  options.memory_limit_mb = arguments.memory_limit_mb;
  options.canceled = [] { return StopSignals::requested(); };
  if (!options.shard.whole() && !arguments.quiet) {
    fmt::print(stderr, "{}: part {} ({})\n", plan.config().name, options.shard.str(), options.shard.source);
  }
  const StopSignals guard;  // stored episodes survive an interrupt
  Progress progress(plan.config().name, arguments.quiet);
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed_s = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const sim::BatchOutcome outcome = sim::run_batch(plan, options, [&](const sim::BatchProgress& p) {
    if (!progress.due()) return;
    const auto todo = static_cast<double>(p.total - p.done + p.flown);  // episodes to fly since this start
    progress.update(todo > 0.0 ? static_cast<double>(p.flown) / todo : 1.0, note_of(p, elapsed_s()));
  });
  progress.finish();
  if (!outcome.complete) {
    throw std::runtime_error(
        fmt::format("interrupted with {} of {} episodes stored; continue with: swiftlet batch {} --out {} --resume",
                    outcome.progress.done, outcome.progress.total, sim::in_shell_quotes(arguments.file),
                    sim::in_shell_quotes(options.out.string())));
  }
  if (!arguments.quiet) print_outcome(outcome, options.out, elapsed_s());
  if (arguments.replays > 0) write_replays(arguments, plan, options.out, options.jobs);
  print_failures(outcome.database);
}

void batch(const BatchArguments& arguments) {
  if (arguments.file.empty())
    throw sim::InputError("batch: expected a batch file, or merge; try 'swiftlet batch --help'");
  const sim::BatchPlan plan(arguments.file, parse_assignments(arguments.set));
  if (arguments.plan) return show_plan(plan);
  if (arguments.replays > 0 && !shard_of(arguments).whole())
    throw sim::InputError("batch: --replays: expected a whole batch, found a part of one; merge all parts first");
  if (arguments.slurm || arguments.submit) return make_cluster_job(arguments, plan);
  fly(arguments, plan);
}

void merge(const MergeArguments& arguments) {
  std::vector<fs::path> sources(arguments.sources.begin(), arguments.sources.end());
  if (sources.empty()) sources.push_back(arguments.out);
  const auto databases = sim::find_databases(sources);
  const sim::MergeOutcome outcome = sim::merge_batches(databases, arguments.out);
  if (!arguments.quiet) {
    fmt::print("{} of {} episodes from {} database{}{}\n", outcome.episodes, outcome.expected, databases.size(),
               databases.size() == 1 ? "" : "s",
               outcome.overlaps > 0 ? fmt::format(", {} of them more than once", outcome.overlaps) : "");
    for (const auto& [status, count] : outcome.by_status) fmt::print("  {:<16} {}\n", status, count);
    fmt::print("  {}\n", (fs::path(arguments.out) / "results.sqlite").string());
  }
  if (outcome.episodes < outcome.expected) {
    std::string missing;
    for (const std::uint64_t id : outcome.first_missing) missing += (missing.empty() ? "" : ", ") + std::to_string(id);
    throw std::runtime_error(fmt::format(
        "{} episodes are missing ({}{}); fly them with: swiftlet batch BATCH.yaml --out {} --resume --shard 1/1",
        outcome.expected - outcome.episodes, missing,
        outcome.expected - outcome.episodes > outcome.first_missing.size() ? ", ..." : "",
        sim::in_shell_quotes(arguments.out)));
  }
}

}  // namespace

void add_batch(CLI::App& app) {
  auto options = std::make_shared<BatchArguments>();
  Subcommand command(app, "batch", "Fly many episodes: variants x parameters x seeds, in worker processes");
  command.option("batch", options->file, "Batch file, or the name of one of Swiftlet's", {.value_name = "BATCH.yaml"});
  command.option("--out", options->out, "Batch directory (default: batches/NAME)", {.value_name = "DIR"});
  command.option("--jobs", options->jobs, "Worker processes (default: one for each processor)",
                 {.value_name = "N", .min = 0, .max = 4096});
  command.option("--shard", options->shard,
                 "Fly part i of n into its own database; default: from Slurm arrays, MPI or indexed Kubernetes jobs",
                 {.value_name = "i/n"});
  command.option("--episodes", options->episodes, "Fly only these episodes of the list of --plan, such as 3,17,40-50",
                 {.value_name = "LIST"});
  command.option("--memory-limit", options->memory_limit_mb,
                 "Memory of one worker on this machine (default: the batch file's memory_limit_mb)",
                 {.value_name = "MiB", .min = 0});
  command.flag("--resume", options->resume, "Fly the episodes that are missing in the batch directory");
  command.flag("--retry", options->retry, "Resume, and repeat episodes that failed, crashed or exceeded a limit");
  command.option("--replays", options->replays, "Fly the N worst episodes again, with replays for the report",
                 {.value_name = "N", .min = 0, .max = 20});
  command.option("--set", options->set, "Override any key of the batch file (may be repeated)",
                 {.value_name = "KEY=VALUE", .repeated = true});
  command.flag("--plan", options->plan, "Print the command of every episode, without flying");
  command.flag("--slurm", options->slurm, "Write a Slurm job array with a merge job instead of flying");
  command.flag("--submit", options->submit, "Write and submit them");
  add_allow_plugins(command, options->allow_plugins);
  command.flag("-q,--quiet", options->quiet, "Print errors only");
  command.action([options] {
    if (options->allow_plugins) allow_plugins();
    batch(*options);
  });

  auto merging = std::make_shared<MergeArguments>();
  Subcommand merge_command = command.subcommand("merge", "Merge the databases of shards");
  merge_command.option("sources", merging->sources, "Batch directories or databases (default: DIR with its shards)",
                       {.value_name = "SOURCE"});
  merge_command.option("--out", merging->out, "Directory of the merged batch", {.value_name = "DIR", .required = true});
  merge_command.flag("-q,--quiet", merging->quiet, "Print errors only");
  merge_command.action([merging] { merge(*merging); });
}

}  // namespace swiftlet::tools
