// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/run_batch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cinttypes>
#include <cmath>
#include <map>

#include "sim/batch/episode.hpp"
#include "sim/batch/writer_lock.hpp"
#include "swiftlet/sim/batch/merge.hpp"
#include "swiftlet/sim/batch/worker_pool.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "tests/sim/batch/batch_support.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kBatch =
    "variants: [{name: light}, {name: heavy, set: {'vehicles[0].airframe.mass_kg': 3}}]\n"
    "sweep: {parameters: [{key: 'wind.mean_mps[0]', name: wind_mps, values: [0, 4]}]}\nseeds: {count: 3}\n";

BatchOutcome run_plan(const BatchPlan& plan, const std::filesystem::path& out, BatchOptions options = {}) {
  options.out = out;
  return run_batch(plan, options, {});
}

BatchOptions on_workers(int count) {
  BatchOptions options;
  options.jobs = count;
  return options;
}

BatchOptions resuming() {
  BatchOptions options;
  options.resume = true;
  return options;
}

BatchOptions retrying() {
  BatchOptions options = resuming();
  options.retry = true;
  return options;
}

std::vector<EpisodeRow> rows(const std::filesystem::path& file) {
  return ResultStore(file, ResultStore::Mode::kRead).episodes();
}
std::string dump(const std::filesystem::path& file) { return ResultStore(file, ResultStore::Mode::kRead).dump(); }

/// State hash of each episode, from a simulation in a process of its own (this process must not start threads).
std::map<std::uint64_t, std::string> hashes_alone(const BatchPlan& plan) {
  std::vector<Job> all;
  for (std::uint64_t id = 0; id < plan.num_episodes(); ++id) all.push_back({id, id});
  const auto fly = [&](std::uint64_t id) {
    Simulation simulation(plan.scenario_of(plan.episode(id)), 1);
    while (!simulation.finished()) simulation.tick();
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016" PRIx64, simulation.state_hash());
    return std::string(hash);
  };
  WorkerPoolOptions options;
  options.jobs_per_worker = 1;
  std::map<std::uint64_t, std::string> hashes;
  WorkerPoolEvents events;
  events.finished = [&](const JobResult& result) { hashes[result.id] = result.bytes; };
  run_jobs(all, fly, options, events);
  return hashes;
}

std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(RunBatch, MatchesEachScenarioRunAlone) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan(kBatch);
  const BatchOutcome outcome = run_plan(plan, folder.path("out"));
  EXPECT_TRUE(outcome.complete);
  EXPECT_EQ(outcome.progress.done, 12U);
  const auto all = rows(outcome.database);
  ASSERT_EQ(all.size(), 12U);
  const auto alone = hashes_alone(plan);
  for (const EpisodeRow& row : all) {
    EXPECT_EQ(row.state_hash, alone.at(row.id)) << row.id;
    EXPECT_EQ(row.status, "done");
    EXPECT_FALSE(row.metrics.empty());
  }
  EXPECT_EQ(all[7].variant, "heavy");
  EXPECT_EQ(all[7].parameters, std::vector<std::string>{"4"});
}

// Task 3 of an array of five is lost and submitted again: its environment counts one task, or those of a new array.
TEST(RunBatch, RefusesPartOfDifferentDivision) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan("seeds: {count: 10}\n");
  const auto fly = [&](Shard shard) {
    BatchOptions options = resuming();
    options.shard = std::move(shard);
    return run_plan(plan, folder.path("out"), options).progress;
  };
  EXPECT_EQ(fly({1, 5, "SLURM_ARRAY_TASK_ID"}).flown, 2U);
  for (const Shard& other : {Shard{0, 1, "SLURM_ARRAY_TASK_ID"}, Shard{1, 2, "SLURM_ARRAY_TASK_ID"},
                             Shard{3, 10, "JOB_COMPLETION_INDEX, PMI_RANK"}}) {
    EXPECT_THAT(refusal([&] { fly(other); }),
                AllOf(HasSubstr(other.source + ": expected one of 5 parts"), HasSubstr("found part " + other.str()),
                      HasSubstr("set --shard i/5")));
  }
  EXPECT_EQ(fly({3, 5, "SLURM_ARRAY_TASK_ID"}).flown, 2U);
  EXPECT_EQ(fly({3, 5, "--shard"}).flown, 0U);
  EXPECT_EQ(fly({0, 2, "--shard"}).flown, 5U) << "another division may be asked for";
}

TEST(RunBatch, LinksInItsDirectoryAreRefused) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan("seeds: {count: 2}\n");
  const fs::path out = folder.path("out"), outside = folder.path("outside");
  fs::create_directories(out);
  fs::create_directories(outside);
  fs::create_symlink(outside / "results.sqlite", out / "results.sqlite");
  fs::create_directory_symlink(outside, out / "shards");
  EXPECT_THAT(refusal([&] { run_plan(plan, out); }), HasSubstr("results.sqlite: expected a database or nothing"));
  BatchOptions part;
  part.shard = {0, 2, "--shard"};
  EXPECT_THAT(refusal([&] { run_plan(plan, out, part); }), HasSubstr("shards: expected a folder or nothing"));
  fs::remove(out / "results.sqlite");
  fs::remove(out / ".results.sqlite.lock");
  fs::create_symlink(outside / "lock", out / ".results.sqlite.lock");
  EXPECT_THAT(refusal([&] { run_plan(plan, out); }), HasSubstr(".results.sqlite.lock: expected a lock file"));
  EXPECT_TRUE(fs::is_empty(outside));
}

TEST(RunBatch, IsIndependentOfWorkerCount) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan(kBatch);
  const auto one = run_plan(plan, folder.path("one"));
  const auto three = run_plan(plan, folder.path("three"), on_workers(3));
  EXPECT_EQ(dump(one.database), dump(three.database));
}

TEST(RunBatch, SharesRandomNumbersAmongSeedVariants) {
  const BatchFolder folder;
  const BatchPlan plan =
      folder.plan("variants: [{name: a}, {name: same}, {name: longer, set: {duration_s: 0.3}}]\nseeds: {count: 2}\n");
  const auto all = rows(run_plan(plan, folder.path("out")).database);
  ASSERT_EQ(all.size(), 6U);
  EXPECT_EQ(all[0].state_hash, all[1].state_hash);
  EXPECT_NE(all[0].state_hash, all[3].state_hash);
  EXPECT_NE(all[0].state_hash, all[2].state_hash);
}

TEST(RunBatch, BuildsSharedWorldOncePerWorker) {
  const BatchFolder folder;
  const auto built = [&](const std::string& text, const std::string& out) {
    int count = 0;
    for (const EpisodeRow& row : rows(run_plan(folder.plan(text), folder.path(out)).database))
      count += row.built_world ? 1 : 0;
    return count;
  };
  EXPECT_EQ(built(kBatch, "own_worlds"), 3);  // one a seed: variants and wind share it
  EXPECT_EQ(built(std::string(kBatch) + "set: {world_seed: 9}\n", "one_world"), 1);
}

TEST(RunBatch, RecordsFailureWithReproducingCommand) {
  const BatchFolder folder;
  // The second point starts both vehicles in one place.
  const BatchPlan plan = folder.plan(
      "sweep: {parameters: [{key: 'vehicles[1].start.position_m[0]', name: x, values: [5, 0]}]}\nseeds: {count: 2}\n");
  const BatchOutcome outcome = run_plan(plan, folder.path("out"));
  EXPECT_TRUE(outcome.complete);
  EXPECT_EQ(outcome.progress.failed, 2U);
  EXPECT_EQ(outcome.by_status.at("failed"), 2U);
  const EpisodeRow row = rows(outcome.database)[3];
  EXPECT_EQ(row.status, "failed");
  EXPECT_EQ(row.seed, 2U);
  EXPECT_THAT(row.message, HasSubstr("start.position_m"));
  EXPECT_THAT(row.command, HasSubstr("--set 'vehicles[1].start.position_m[0]=0' --seed 2"));
}

TEST(RunBatch, ResumingFliesOnlyWhatIsMissing) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan(kBatch);
  const auto whole = run_plan(plan, folder.path("whole"));
  int stored = 0;
  BatchOptions options;
  options.out = folder.path("out");
  options.canceled = [&] { return stored >= 5; };
  const BatchOutcome first =
      run_batch(plan, options, [&](const BatchProgress& p) { stored = static_cast<int>(p.done); });
  EXPECT_FALSE(first.complete);
  EXPECT_GE(first.progress.done, 5U);
  EXPECT_LT(first.progress.done, 12U);
  const BatchOutcome second = run_plan(plan, folder.path("out"), resuming());
  EXPECT_TRUE(second.complete);
  EXPECT_EQ(second.progress.done, 12U);
  EXPECT_EQ(second.progress.flown, 12U - first.progress.done);
  EXPECT_EQ(dump(second.database), dump(whole.database));
  EXPECT_EQ(run_plan(plan, folder.path("out"), resuming()).progress.flown, 0U);
}

TEST(RunBatch, RunsChosenEpisodesAndRestLater) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan(kBatch);
  BatchOptions options;
  options.episodes = {2, 7};
  const auto two = run_plan(plan, folder.path("out"), options);
  EXPECT_TRUE(two.complete);
  EXPECT_EQ(two.progress.total, 2U);
  const auto flown = rows(two.database);
  ASSERT_EQ(flown.size(), 2U);
  EXPECT_EQ(flown[0].id, 2U);
  EXPECT_EQ(flown[1].id, 7U);
  const auto rest = run_plan(plan, folder.path("out"), resuming());
  EXPECT_EQ(rest.progress.flown, 10U);
  EXPECT_EQ(dump(rest.database), dump(run_plan(plan, folder.path("whole")).database));
}

TEST(RunBatch, NeitherOverwritesNorMixesResults) {
  const BatchFolder folder;
  const BatchPlan plan = folder.plan(kBatch);
  run_plan(plan, folder.path("out"));
  EXPECT_THAT(refusal([&] { run_plan(plan, folder.path("out")); }), HasSubstr("--resume"));
  const BatchPlan other = folder.plan(std::string(kBatch) + "set: {duration_s: 0.1}\n");
  EXPECT_THAT(refusal([&] { run_plan(other, folder.path("out"), resuming()); }),
              HasSubstr("another meaning (set.duration_s: nothing then, \"0.1\" now)"));
  const BatchPlan more = folder.plan(std::string(kBatch) + "set: {duration_s: 0.2}\n");
  run_plan(other, folder.path("other"));
  EXPECT_THAT(refusal([&] { run_plan(more, folder.path("other"), resuming()); }),
              HasSubstr("another meaning (set.duration_s: \"0.1\" then, \"0.2\" now)"));
  const BatchPlan same = folder.plan(std::string("# a comment\ntimeout_s: 50\n") + kBatch);
  EXPECT_EQ(run_plan(same, folder.path("out"), resuming()).progress.flown, 0U);
}

TEST(RunBatch, RetriesOnlyFailuresOnRequest) {
  const BatchFolder folder;
  const std::string text = "sweep: {parameters: [{key: duration_s, values: [0.1, 100000]}]}\nseeds: {count: 1}\n";
  const BatchOutcome first = run_plan(folder.plan("timeout_s: 1\n" + text), folder.path("out"));
  EXPECT_EQ(first.by_status.at("timed_out"), 1U);
  EXPECT_EQ(first.by_status.at("done"), 1U);
  const BatchPlan plan = folder.plan("timeout_s: 1.5\n" + text);
  EXPECT_EQ(run_plan(plan, folder.path("out"), resuming()).progress.flown, 0U);
  EXPECT_EQ(run_plan(plan, folder.path("out"), retrying()).progress.flown, 1U);
}

TEST(EpisodeResult, SurvivesATransferThroughAPipe) {
  EpisodeResult result;
  result.outcome = "crashed";
  result.state_hash = 0xFEDCBA9876543210ULL;
  result.simulated_s = 0.1;
  result.metrics = {
      {"a_m", "uav1", 1.0 / 3.0, "m", ""}, {"b", "", std::nan(""), "", ""}, {"c", "uav2", 0.0, "", "tree \"7\""}};
  const EpisodeResult back = episode_result_from_bytes(to_bytes(result));
  EXPECT_EQ(back.state_hash, result.state_hash);
  EXPECT_EQ(back.metrics[0].value, 1.0 / 3.0);
  EXPECT_TRUE(std::isnan(back.metrics[1].value));
  EXPECT_EQ(back.metrics[2].text, "tree \"7\"");
}

class Merge : public ::testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 3; ++i) {
      BatchOptions options;
      options.shard = {i, 3, ""};
      shards_.push_back(run_plan(plan_, folder_.path("out"), options).database);
    }
    whole_ = run_plan(plan_, folder_.path("whole")).database;
  }

  BatchFolder folder_;
  BatchPlan plan_ = folder_.plan(kBatch);
  std::vector<std::filesystem::path> shards_;
  std::filesystem::path whole_;
};

TEST_F(Merge, MatchesSingleMachineInAnyOrder) {
  EXPECT_EQ(find_databases({folder_.path("out")}).size(), 3U);
  const MergeOutcome outcome = merge_batches(find_databases({folder_.path("out")}), folder_.path("out"));
  EXPECT_EQ(outcome.episodes, 12U);
  EXPECT_EQ(outcome.expected, 12U);
  EXPECT_EQ(dump(folder_.path("out/results.sqlite")), dump(whole_));
  merge_batches({shards_[2], shards_[0], shards_[1]}, folder_.path("other"));
  EXPECT_EQ(dump(folder_.path("other/results.sqlite")), dump(whole_));
  EXPECT_TRUE(std::filesystem::exists(folder_.path("other/episodes.csv")));
}

TEST_F(Merge, ReportsMissingAndExtendsExisting) {
  const MergeOutcome part = merge_batches({shards_[0], shards_[2]}, folder_.path("part"));
  EXPECT_EQ(part.episodes, 8U);
  EXPECT_EQ(part.first_missing.size(), 4U);
  const MergeOutcome all = merge_batches({shards_[1]}, folder_.path("part"));
  EXPECT_EQ(all.episodes, 12U);
  EXPECT_EQ(dump(folder_.path("part/results.sqlite")), dump(whole_));
}

TEST_F(Merge, RefusesWhileBatchIsWriting) {
  int started[2], ended[2];
  ASSERT_EQ(pipe(started) | pipe(ended), 0);
  const pid_t batch = fork();
  ASSERT_GE(batch, 0);
  char byte = 0;
  if (batch == 0) {
    close(ended[1]);
    const WriterLock lock(whole_);
    (void)!write(started[1], &byte, 1);
    (void)!read(ended[0], &byte, 1);
    _exit(0);
  }
  ASSERT_EQ(read(started[0], &byte, 1), 1);
  const std::string before = dump(whole_);
  EXPECT_THAT(refusal([&] { merge_batches({shards_[0]}, folder_.path("whole")); }),
              HasSubstr("results.sqlite.lock: expected no other writer"));
  EXPECT_EQ(dump(whole_), before);
  close(ended[1]);
  waitpid(batch, nullptr, 0);
  merge_batches({shards_[0]}, folder_.path("whole"));
  for (const int fd : {started[0], started[1], ended[0]}) close(fd);
}

TEST_F(Merge, RemovesOnlyRemnantsOfKilledMerge) {
  const fs::path out = folder_.path("after_a_kill");
  const std::vector<std::string> left = {".results.merging-17.sqlite", ".results.merging-17.sqlite-wal",
                                         ".results.merging-17.sqlite-shm", ".results.merging-4242.sqlite-journal"};
  const std::vector<std::string> foreign = {".results.merging-notes.sqlite", ".results.merging-.sqlite",
                                            ".results.merging-17.sqlite.bak", ".results.merging-17"};
  for (const auto& names : {left, foreign}) {
    for (const std::string& name : names) write_file(out / name, "text", MissingFolders::kMade);
  }
  merge_batches({shards_[0]}, out);
  for (const std::string& name : left) EXPECT_FALSE(fs::exists(out / name)) << name;
  for (const std::string& name : foreign) EXPECT_TRUE(fs::exists(out / name)) << name;
}

TEST_F(Merge, WritesThroughNoLink) {
  const fs::path outside = folder_.path("outside.sqlite"), out = folder_.path("linked");
  write_file(outside, "precious");
  fs::create_directories(out);
  const fs::path unfinished = out / (".results.merging-" + std::to_string(getpid()) + ".sqlite");
  fs::create_symlink(outside, unfinished);
  fs::create_symlink(outside, unfinished.string() + "-wal");
  merge_batches({shards_[0]}, out);
  EXPECT_EQ(read_whole_file(outside), "precious");
  EXPECT_FALSE(fs::is_symlink(out / "results.sqlite"));
}

TEST_F(Merge, OverlapsThatAgreeAreOne) {
  const MergeOutcome outcome = merge_batches({shards_[0], whole_, shards_[0]}, folder_.path("twice"));
  EXPECT_EQ(outcome.episodes, 12U);
  EXPECT_EQ(outcome.overlaps, 8U);
  EXPECT_EQ(dump(folder_.path("twice/results.sqlite")), dump(whole_));
}

TEST_F(Merge, RefusesConflictingOverlapsWithoutTrace) {
  {
    ResultStore store(shards_[1], ResultStore::Mode::kAppend);
    EpisodeRow row = store.episodes().front();
    for (MetricRow& metric : row.metrics) {
      if (metric.name == "path_length_m") metric.value += 1e-12;
    }
    store.add(row);
  }
  const std::string message = refusal([&] { merge_batches({whole_, shards_[1]}, folder_.path("bad")); });
  EXPECT_THAT(message, HasSubstr("path_length_m"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path("bad/results.sqlite")));
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path("bad")))
    EXPECT_EQ(entry.path().filename(), ".results.sqlite.lock");
}

TEST_F(Merge, PrefersFinishedOverUnfinishedEpisodes) {
  {
    ResultStore store(shards_[1], ResultStore::Mode::kAppend);
    EpisodeRow row = store.episodes().front();
    row.status = "timed_out";
    row.outcome = row.state_hash = "";
    row.metrics.clear();
    store.add(row);
  }
  merge_batches({shards_[1], whole_}, folder_.path("a"));
  merge_batches({whole_, shards_[1]}, folder_.path("b"));
  EXPECT_EQ(dump(folder_.path("a/results.sqlite")), dump(whole_));
  EXPECT_EQ(dump(folder_.path("b/results.sqlite")), dump(whole_));
}

TEST_F(Merge, ShardsOfAnotherBatchAreRefused) {
  const BatchPlan other = folder_.plan(std::string(kBatch) + "set: {duration_s: 0.1}\n");
  const auto foreign = run_plan(other, folder_.path("foreign")).database;
  EXPECT_THAT(refusal([&] {
                merge_batches({shards_[0], foreign}, folder_.path("mixed"));
              }),
              HasSubstr("another meaning"));
  folder_.write("text.sqlite",
                "this is no database, whatever its name says; it is long enough to be read as one, though");
  EXPECT_NE(refusal([&] { merge_batches({folder_.path("text.sqlite")}, folder_.path("mixed")); }), "");
}

}  // namespace
}  // namespace swiftlet::sim
