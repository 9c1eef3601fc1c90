// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/worker_pool.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <thread>

#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

using Results = std::map<std::uint64_t, JobResult>;

std::vector<Job> jobs(std::uint64_t count, std::uint64_t group_size = 1) {
  std::vector<Job> list;
  for (std::uint64_t i = 0; i < count; ++i) list.push_back({i, i / group_size});
  return list;
}

Results results_of(const std::vector<Job>& list, const std::function<std::string(std::uint64_t)>& work,
                   const WorkerPoolOptions& options) {
  Results results;
  WorkerPoolEvents events;
  events.finished = [&](JobResult result) {
    EXPECT_FALSE(results.contains(result.id)) << "reported twice";
    results[result.id] = std::move(result);
  };
  EXPECT_TRUE(run_jobs(list, work, options, events));
  return results;
}

WorkerPoolOptions workers(int count) {
  WorkerPoolOptions options;
  options.workers = count;
  return options;
}

bool is_alive(pid_t pid) { return ::kill(pid, 0) == 0; }

bool dies_within(pid_t pid, double seconds) {
  for (int i = 0; i < 100 * seconds; ++i) {
    if (!is_alive(pid)) return true;
    ::usleep(10'000);
  }
  return !is_alive(pid);
}

TEST(WorkerPool, ReturnsResultsForAnyWorkerCount) {
  const auto work = [](std::uint64_t job) { return std::string(job * 20'000, static_cast<char>('a' + job)); };
  for (const int count : {1, 2, 5}) {
    const Results results = results_of(jobs(12), work, workers(count));
    ASSERT_EQ(results.size(), 12U);
    for (const auto& [id, result] : results) {
      EXPECT_EQ(result.status, JobStatus::kDone);
      EXPECT_EQ(result.bytes, work(id));
    }
  }
}

TEST(WorkerPool, RunsPersistentWorkersInSeparateProcesses) {
  int made = 0;  // the closure's state lives on in the worker, not here
  const auto work = [&](std::uint64_t) {
    ++made;
    return std::to_string(::getpid()) + " " + std::to_string(made);
  };
  const Results results = results_of(jobs(3), work, workers(1));
  const std::string pid = results.at(0).bytes.substr(0, results.at(0).bytes.find(' '));
  EXPECT_NE(pid, std::to_string(::getpid()));
  EXPECT_EQ(results.at(2).bytes, pid + " 3");
  EXPECT_EQ(made, 0);
}

TEST(WorkerPool, ReportsCrashAndContinuesOtherJobs) {
  const auto work = [](std::uint64_t job) -> std::string {
    if (job == 3) {
      std::fprintf(stderr, "first words\nthe last words\n");
      std::abort();
    }
    if (job == 5) ::_exit(9);
    if (job == 7) throw std::runtime_error("no such leaf");
    return "fine";
  };
  const Results results = results_of(jobs(10), work, workers(2));
  ASSERT_EQ(results.size(), 10U);
  EXPECT_EQ(results.at(3).status, JobStatus::kCrashed);
  EXPECT_NE(results.at(3).message.find("signal 6"), std::string::npos) << results.at(3).message;
  EXPECT_NE(results.at(3).message.find("the last words"), std::string::npos) << results.at(3).message;
  EXPECT_EQ(results.at(5).status, JobStatus::kCrashed);
  EXPECT_NE(results.at(5).message.find("status 9"), std::string::npos);
  EXPECT_EQ(results.at(7).status, JobStatus::kFailed);
  EXPECT_EQ(results.at(7).message, "no such leaf");
  for (const auto& [id, result] : results) {
    if (id != 3 && id != 5 && id != 7) {
      EXPECT_EQ(result.bytes, "fine");
    }
  }
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(WorkerPool, ReportsJobsThatExhaustTheirMemory) {
  WorkerPoolOptions options = workers(2);
  options.memory_limit_mb = 300.0;
  const auto work = [](std::uint64_t job) -> std::string {
    std::vector<std::string> eaten;
    while (job == 2) eaten.emplace_back(10'000'000, 'x');
    return "fine";
  };
  const Results results = results_of(jobs(4), work, options);
  EXPECT_EQ(results.at(2).status, JobStatus::kOutOfMemory);
  EXPECT_EQ(results.at(3).status, JobStatus::kDone);
}
#endif

TEST(WorkerPool, RetriesInFreshWorkerAfterCorruption) {
  bool broken = false;
  const auto work = [&](std::uint64_t job) -> std::string {
    if (broken) std::abort();
    if (job == 1) broken = true;
    return std::to_string(::getpid());
  };
  const Results results = results_of(jobs(6), work, workers(1));
  ASSERT_EQ(results.size(), 6U);
  for (const auto& [id, result] : results) EXPECT_EQ(result.status, JobStatus::kDone) << id << " " << result.message;
  EXPECT_NE(results.at(0).bytes, results.at(5).bytes);
}

TEST(WorkerPool, AWorkerStaysWithItsGroup) {
  std::set<std::uint64_t> seen;  // groups of this worker so far
  const auto work = [&](std::uint64_t job) {
    seen.insert(job / 5);
    ::usleep(2'000);
    return std::to_string(::getpid()) + " " + std::to_string(seen.size());
  };
  // 8 groups for 2 workers: a group stays with its worker, except the last one, which may be shared.
  const Results results = results_of(jobs(40, 5), work, workers(2));
  std::map<std::string, int> built;  // groups begun, per worker
  for (const auto& [id, result] : results) {
    const std::size_t blank = result.bytes.find(' ');
    int& most = built[result.bytes.substr(0, blank)];
    most = std::max(most, std::stoi(result.bytes.substr(blank + 1)));
  }
  int all = 0;
  for (const auto& [pid, count] : built) all += count;
  EXPECT_EQ(built.size(), 2U);
  EXPECT_GE(all, 8);
  EXPECT_LE(all, 9);
}

TEST(WorkerPool, ReplacesWorkersAfterShareOfJobs) {
  WorkerPoolOptions options = workers(1);
  options.jobs_per_worker = 2;
  const Results results = results_of(
      jobs(6), [](std::uint64_t) { return std::to_string(::getpid()); }, options);
  std::set<std::string> pids;
  for (const auto& [id, result] : results) pids.insert(result.bytes);
  EXPECT_EQ(pids.size(), 3U);
}

TEST(WorkerPool, CancelingLeavesNoProcessBehind) {
  const TemporaryDirectory folder;
  const auto work = [&](std::uint64_t job) -> std::string {
    std::ofstream(folder.path() / std::to_string(::getpid())) << "here";
    while (job >= 2) ::pause();
    return "fine";
  };
  int done = 0;
  WorkerPoolOptions options = workers(2);
  options.canceled = [&] {
    return done == 2 && std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 2;
  };
  WorkerPoolEvents events;
  events.finished = [&](const JobResult&) { ++done; };
  EXPECT_FALSE(run_jobs(jobs(50), work, options, events));
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_FALSE(is_alive(std::stoi(entry.path().filename().string())));
  }
}

TEST(WorkerPool, WorkersDieWithTheirParentProcess) {
  const TemporaryDirectory folder;
  const pid_t coordinator = ::fork();
  if (coordinator == 0) {
    const auto work = [&](std::uint64_t) -> std::string {
      std::ofstream(folder.path() / std::to_string(::getpid())) << "here";
      for (;;) ::pause();
    };
    run_jobs(jobs(2), work, workers(2), {});
    ::_exit(0);
  }
  const auto pids = [&] {
    std::vector<pid_t> list;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
      list.push_back(std::stoi(entry.path().filename().string()));
    }
    return list;
  };
  for (int i = 0; i < 500 && pids().size() < 2; ++i) ::usleep(10'000);
  const std::vector<pid_t> started = pids();
  ASSERT_EQ(started.size(), 2U);
  ::kill(coordinator, SIGKILL);
  ::waitpid(coordinator, nullptr, 0);
  for (const pid_t pid : started) EXPECT_TRUE(dies_within(pid, 5.0));
}

#if !defined(__SANITIZE_THREAD__)  // ThreadSanitizer has a thread of its own
TEST(WorkerPool, RefusesToForkProcessWithThreads) {
  std::atomic<bool> over = false;
  std::thread other([&] {
    while (!over) std::this_thread::yield();
  });
  EXPECT_THROW(run_jobs(jobs(1), [](std::uint64_t) { return std::string(); }, workers(1), {}), std::logic_error);
  over = true;
  other.join();
}
#endif

TEST(WorkerPool, LimitsWorkersToRequestAndJobs) {
  for (const auto& [count, all, expected] : {std::tuple(3, 9, 3U), std::tuple(3, 2, 2U), std::tuple(0, 2, 1U)}) {
    const auto work = [](std::uint64_t) {
      ::usleep(20'000);
      return std::to_string(::getpid());
    };
    std::set<std::string> pids;
    for (const auto& [id, result] : results_of(jobs(static_cast<std::uint64_t>(all)), work, workers(count)))
      pids.insert(result.bytes);
    EXPECT_EQ(pids.size(), expected) << count << " workers for " << all << " jobs";
  }
}

TEST(WorkerPool, ReportsStartedJobsAndRunningCount) {
  std::vector<std::uint64_t> started, finished;
  int most = 0;
  WorkerPoolEvents events;
  events.started = [&](std::uint64_t job) { started.push_back(job); };
  events.finished = [&](const JobResult& result) { finished.push_back(result.id); };
  events.idle = [&](int running) {
    most = std::max(most, running);
    EXPECT_GE(running, 1);
    EXPECT_LE(running, 2);
  };
  const auto work = [](std::uint64_t) {
    ::usleep(250'000);
    return std::string();
  };
  EXPECT_TRUE(run_jobs(jobs(3), work, workers(2), events));
  EXPECT_EQ(started, (std::vector<std::uint64_t>{0, 1, 2})) << "in the given order";
  EXPECT_EQ(finished.size(), 3U);
  EXPECT_GE(most, 1);
}

TEST(WorkerPool, ShortensTheLastLineOfWorkers) {
  const std::pair<std::string, std::string> cases[] = {
      {"", ""},
      {"\n \n", ""},
      {"first\nlast \n\n", ": last"},
      {"a\tb\x1F c ~", ": a b  c ~"},
      {std::string(301, 'x'), ": " + std::string(300, 'x')},
      {std::string(2000, 'y') + "\nshort", ": short"},
  };
  for (const auto& [text, reported] : cases) {
    const auto work = [&text = text](std::uint64_t) -> std::string {
      (void)!::write(STDERR_FILENO, text.data(), text.size());
      ::_exit(9);
    };
    EXPECT_EQ(results_of(jobs(1), work, workers(1)).at(0).message, "the worker ended with status 9" + reported);
  }
}

TEST(WorkerPool, ExplainsTheUsualCauseOfKills) {
  const auto work = [](std::uint64_t) -> std::string {
    ::kill(::getpid(), SIGKILL);
    return "";
  };
  const JobResult result = results_of(jobs(1), work, workers(1)).at(0);
  EXPECT_EQ(result.status, JobStatus::kCrashed);
  EXPECT_EQ(result.message, "killed by signal 9 (Killed), for lack of memory or by another process");
}

TEST(WorkerPool, RecognizesMemoryExhaustionInAnyWording) {
  const auto work = [](std::uint64_t job) -> std::string {
    if (job == 0) throw std::bad_alloc();
    if (job == 1) throw std::runtime_error("mesa: out of memory while drawing");
    throw std::runtime_error("of memory");
  };
  const Results results = results_of(jobs(3), work, workers(1));
  EXPECT_EQ(results.at(0).status, JobStatus::kOutOfMemory);
  EXPECT_EQ(results.at(0).message, "out of memory");
  EXPECT_EQ(results.at(1).status, JobStatus::kOutOfMemory);
  EXPECT_EQ(results.at(2).status, JobStatus::kFailed);
}

TEST(WorkerPool, ReportsTimeoutsAndReplacesTheWorker) {
  WorkerPoolOptions options = workers(1);
  options.timeout_s = 0.3;
  const auto work = [](std::uint64_t job) -> std::string {
    while (job == 0) ::pause();
    return std::to_string(::getpid());
  };
  const Results results = results_of(jobs(3), work, options);
  EXPECT_EQ(results.at(0).status, JobStatus::kTimedOut);
  EXPECT_GE(results.at(0).wall_s, 0.3);
  EXPECT_EQ(results.at(0).message, "exceeded 0.3 s of wall time");
  EXPECT_EQ(results.at(1).status, JobStatus::kDone);
  EXPECT_EQ(results.at(1).bytes, results.at(2).bytes);
}

TEST(WorkerPool, EndsWorkersWhenACallbackThrows) {
  WorkerPoolEvents events;
  events.finished = [](const JobResult&) { throw std::runtime_error("disk full"); };
  EXPECT_THROW(run_jobs(
                   jobs(4), [](std::uint64_t) { return std::string("x"); }, workers(2), events),
               std::runtime_error);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);  // no child left
}

}  // namespace
}  // namespace swiftlet::sim
