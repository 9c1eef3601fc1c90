// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/run_batch.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <system_error>

#include "sim/batch/difference.hpp"
#include "sim/batch/episode.hpp"
#include "sim/batch/writer_lock.hpp"
#include "swiftlet/sim/batch/worker_pool.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/run/version.hpp"
#include "swiftlet/sim/scenario/document.hpp"
#include "swiftlet/sim/scenario/yaml_writer.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

std::string host_name() {
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
}

/// Database row of an episode.
EpisodeRow row_of(const BatchPlan& plan, const JobResult& result) {
  const Episode episode = plan.episode(result.id);
  EpisodeRow row;
  row.id = episode.id;
  row.variant = plan.config().variants[episode.variant].name;
  row.point = episode.point;
  row.seed = episode.seed;
  row.parameters = plan.points()[episode.point];
  row.status = name_of(result.status);
  row.message = result.message;
  row.command = plan.command_of(episode);
  row.wall_s = result.wall_s;
  row.host = host_name();
  row.simulated_s = row.setup_wall_s = row.flight_wall_s = std::nan("");
  if (result.status != JobStatus::kDone) return row;
  EpisodeResult flown = episode_result_from_bytes(result.bytes);
  row.outcome = flown.outcome;
  row.state_hash = hex64(flown.state_hash);
  row.simulated_s = flown.simulated_s;
  row.metrics = std::move(flown.metrics);
  row.setup_wall_s = flown.setup_wall_s;
  row.flight_wall_s = flown.flight_wall_s;
  row.built_world = flown.built_world;
  return row;
}

/// Throws InputError when the directory contains shards of a batch divided into another number of shards. Resubmitted
/// cluster tasks may count only themselves, and would fly episodes twice. `--shard` is trusted.
void require_same_division(const fs::path& out, const Shard& shard) {
  if (shard.source.empty() || shard.source == "--shard") return;
  constexpr std::string_view kOf = "-of-";
  std::error_code absent;
  for (const fs::directory_entry& entry : fs::directory_iterator(out / "shards", absent)) {
    const std::string name = entry.path().stem().string();
    const std::size_t at = name.find(kOf);
    if (entry.path().extension() != ".sqlite" || at == std::string::npos) continue;
    const std::string count = name.substr(at + kOf.size());
    if (count == std::to_string(shard.count)) continue;
    throw InputError(shard.source + ": expected one of " + count + " parts, as in " + entry.path().string() +
                     ", found part " + shard.str() + "; set --shard i/" + count + " instead, or choose another --out");
  }
}

ResultStore open_store(const BatchPlan& plan, const BatchOptions& options, const fs::path& file) {
  ResultStore store(file, ResultStore::Mode::kAppend);
  const BatchInfo wanted = info_of(plan);
  const auto stored = store.info();
  if (stored && !options.resume) {
    throw InputError(file.string() + ": expected no results, found those of the batch \"" + stored->name +
                     "\"; continue it with --resume, or choose another --out");
  }
  if (stored) require_same_batch(*stored, wanted, file);
  if (!stored) store.set_info(wanted);
  return store;
}

WorkerPoolOptions pool_options(const BatchPlan& plan, const BatchOptions& options) {
  WorkerPoolOptions pool;
  pool.workers = options.jobs;
  pool.timeout_s = plan.config().timeout_s;
  pool.memory_limit_mb = options.memory_limit_mb > 0.0 ? options.memory_limit_mb : plan.config().memory_limit_mb;
  pool.jobs_per_worker = plan.config().episodes_per_worker;
  pool.canceled = options.canceled;
  return pool;
}

/// First difference of two batch files in a key that alters episodes, with both values; empty if there is none.
std::string first_change(const std::string& then_text, const std::string& now_text) {
  const Node then = parse_document(then_text, {"then", "."}), now = parse_document(now_text, {"now", "."});
  for (const char* key : {"scenario", "set", "variants", "sweep", "seeds"}) {
    const Node *before = then.find(key), *after = now.find(key);
    const Node none;
    std::string found = first_difference(before != nullptr ? *before : none, after != nullptr ? *after : none, key);
    if (!found.empty()) return found;
  }
  return {};
}

}  // namespace

fs::path database_path(const fs::path& out, const Shard& shard) {
  if (shard.whole()) return out / "results.sqlite";
  const std::size_t width = std::to_string(shard.count).size();
  return out / "shards" / fmt::format("{:0{}}-of-{}.sqlite", shard.index + 1, width, shard.count);
}

BatchInfo info_of(const BatchPlan& plan) {
  BatchInfo info;
  BatchConfig config = plan.config();
  info.name = config.name;
  info.description = config.description;
  info.file = plan.file().string();
  info.text = write_config([&](ConfigVisitor& v) { config.visit(v); });
  info.fingerprint = plan.fingerprint();
  info.version = version();
  info.git_revision = git_revision();
  info.num_episodes = plan.num_episodes();
  for (const VariantConfig& variant : config.variants) info.variants.push_back(variant.name);
  for (const ParameterConfig& parameter : config.sweep.parameters) info.parameters.push_back(parameter.name);
  return info;
}

void require_same_batch(const BatchInfo& stored, const BatchInfo& wanted, const fs::path& database) {
  const std::string prefix = database.string() + ": ";
  if (stored.version != wanted.version) {
    throw InputError(prefix + "expected results of Swiftlet " + wanted.version + ", found those of " + stored.version +
                     "; results of two versions do not mix: choose another --out");
  }
  if (stored.fingerprint == wanted.fingerprint) return;
  std::string what = first_change(stored.text, wanted.text);
  if (what.empty()) what = "the scenario, or a model or file that it names";
  throw InputError(prefix + "expected results of the same batch, found those of a batch with another meaning (" + what +
                   "); continue it with the original files, or choose another --out");
}

BatchOutcome run_batch(const BatchPlan& plan, const BatchOptions& options,
                       const std::function<void(const BatchProgress&)>& report) {
  require_same_division(options.out, options.shard);
  BatchOutcome outcome;
  outcome.database = database_path(options.out, options.shard);
  make_directory(options.out);
  if (!options.shard.whole()) make_inner_directory(outcome.database.parent_path());
  const WriterLock lock(outcome.database);
  ResultStore store = open_store(plan, options, outcome.database);
  if (options.retry) store.remove_unfinished();

  const std::set<std::uint64_t> known = store.episode_ids();
  std::vector<Job> jobs;
  BatchProgress& progress = outcome.progress;
  for (const std::uint64_t id : plan.episodes_of(options.shard)) {
    const std::vector<std::uint64_t>& chosen = options.episodes;
    if (!chosen.empty() && !std::binary_search(chosen.begin(), chosen.end(), id)) continue;
    ++progress.total;
    if (known.contains(id)) {
      ++progress.done;
    } else {
      jobs.push_back({id, plan.group_of(plan.episode(id))});
    }
  }
  for (const auto& [status, count] : store.count_by_status()) progress.failed += status == "done" ? 0 : count;

  EpisodeRunner runner(plan);  // copied to each worker process, which keeps its state between jobs
  WorkerPoolEvents events;
  events.finished = [&](const JobResult& result) {
    try {
      store.add(row_of(plan, result));
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(std::string(error.what()) + "; " + std::to_string(progress.done) +
                               " episodes are stored; continue with --resume");
    }
    ++progress.done;
    ++progress.flown;
    progress.failed += result.status == JobStatus::kDone ? 0 : 1;
    if (report) report(progress);
  };
  events.idle = [&](int running) {
    progress.running = running;
    if (report) report(progress);
  };
  outcome.complete = run_jobs(
      jobs, [&](std::uint64_t id) { return to_bytes(runner.fly(id)); }, pool_options(plan, options), events);
  progress.running = 0;
  outcome.by_status = store.count_by_status();
  if (options.shard.whole()) export_csv(store, options.out);
  store.close();
  return outcome;
}

}  // namespace swiftlet::sim
