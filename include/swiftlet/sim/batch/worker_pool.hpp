// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

/// Jobs in worker processes. A job is a number, its result a string of bytes. A job that crashes, runs out of time or
/// of memory is a result like any other and takes nothing else down.
namespace swiftlet::sim {

struct Job {
  std::uint64_t id = 0;
  /// Jobs of one group share something dear (a world) that a worker keeps between jobs. A worker stays with its group
  /// as long as there are jobs of it. Then it prefers a group that nobody works on to another worker's.
  std::uint64_t group = 0;
};

enum class JobStatus { kDone, kFailed, kCrashed, kTimedOut, kOutOfMemory };

/// "done", "failed", "crashed", "timed_out", "out_of_memory".
const char* name_of(JobStatus status);

struct JobResult {
  std::uint64_t id = 0;
  JobStatus status = JobStatus::kDone;
  std::string bytes;    ///< kDone: what the work returned
  std::string message;  ///< otherwise: one line that says why
  double wall_s = 0.0;
};

struct WorkerPoolOptions {
  int workers = 1;                 ///< processes at a time
  double timeout_s = 0.0;          ///< wall time of one job; 0: none
  double memory_limit_mb = 0.0;    ///< of one worker (its data and anonymous maps, RLIMIT_DATA); 0: none
  int jobs_per_worker = 0;         ///< a worker is replaced after so many jobs; 0: never
  std::function<bool()> canceled;  ///< asked several times a second and after every signal; true: stop now
};

/// What happens, told in the process that called run_jobs().
struct WorkerPoolEvents {
  std::function<void(std::uint64_t job)> started;
  std::function<void(JobResult result)> finished;  ///< in the order of completion; may throw: workers are ended first
  std::function<void(int running)> idle;           ///< several times a second
};

/// Calls `work(job)` for every job in worker processes and hands over the results. A worker keeps whatever `work` holds
/// from one job to the next (a cache in the closure). What the work throws makes the job kFailed (std::bad_alloc:
/// kOutOfMemory). A job may crash or run out of memory in a worker that had done others before. It is tried once more
/// in a fresh one, so that only its own doing counts.
///
/// Workers are forks of this process. It must have no thread but this one, from here until the return. Anything else
/// throws std::logic_error (OpenMP's threads stay once started). Workers ignore SIGINT and SIGTERM, which are this
/// process's to answer through `canceled`, and die with it. What they print on stdout or stderr is kept, and its last
/// line is part of the message when they crash.
/// @return false when canceled; jobs that were running then have no result
bool run_jobs(const std::vector<Job>& jobs, const std::function<std::string(std::uint64_t job)>& work,
              const WorkerPoolOptions& options, const WorkerPoolEvents& events);

}  // namespace swiftlet::sim
