// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

/// Jobs in worker processes. A job is a number, its result a string of bytes. A job that crashes, runs out of time or
/// of memory gives a result with that status and does not affect other jobs.
namespace swiftlet::sim {

struct Job {
  std::uint64_t id = 0;
  /// Jobs of one group share an expensive resource (a world) that a worker keeps between jobs. A worker takes jobs of
  /// its group while there are any, then jobs of a group without a worker, then jobs of another worker's group.
  std::uint64_t group = 0;
};

enum class JobStatus { kDone, kFailed, kCrashed, kTimedOut, kOutOfMemory };

/// "done", "failed", "crashed", "timed_out", "out_of_memory".
const char* name_of(JobStatus status);

struct JobResult {
  std::uint64_t id = 0;
  JobStatus status = JobStatus::kDone;
  std::string bytes;    ///< kDone: result of the work
  std::string message;  ///< all other statuses: the reason, in one line
  double wall_s = 0.0;
};

struct WorkerPoolOptions {
  int workers = 1;                 ///< processes at a time
  double timeout_s = 0.0;          ///< wall time limit of one job; 0: none
  double memory_limit_mb = 0.0;    ///< limit of one worker's data and anonymous maps (RLIMIT_DATA); 0: none
  int jobs_per_worker = 0;         ///< number of jobs after which a worker is replaced; 0: never
  std::function<bool()> canceled;  ///< polled several times a second and after every signal; true: stop now
};

/// Callbacks, called in the process of run_jobs().
struct WorkerPoolEvents {
  std::function<void(std::uint64_t job)> started;
  /// In the order of completion; may throw: then the workers are ended first
  std::function<void(JobResult result)> finished;
  std::function<void(int running)> idle;  ///< several times a second
};

/// Calls `work(job)` for every job in worker processes and reports the results. A worker keeps the state that `work`
/// holds (a cache in the closure) from one job to the next. An exception from `work` makes the job kFailed
/// (std::bad_alloc: kOutOfMemory). A job that crashes or runs out of memory in a used worker is repeated once in a
/// fresh one, so that earlier jobs cannot cause its failure.
///
/// Workers are forks of this process, which must have no other thread from here until the return; otherwise
/// std::logic_error is thrown (threads of OpenMP persist once started). Workers ignore SIGINT and SIGTERM, which this
/// process handles through `canceled`, and end with it. Their output on stdout and stderr is captured, and its last
/// line is part of the message when they crash.
/// @return false when canceled; jobs running at that time have no result
bool run_jobs(const std::vector<Job>& jobs, const std::function<std::string(std::uint64_t job)>& work,
              const WorkerPoolOptions& options, const WorkerPoolEvents& events);

}  // namespace swiftlet::sim
