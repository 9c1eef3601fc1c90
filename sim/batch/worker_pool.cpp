// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/worker_pool.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <deque>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/run/memory.hpp"

namespace swiftlet::sim {
namespace {

using Clock = std::chrono::steady_clock;
using Work = std::function<std::string(std::uint64_t)>;

// [ms] Period of checks for time-outs and cancellation. Larger values react later.
constexpr int kPollPeriod_ms = 100;
// [bytes] Size above which a reply counts as corrupt.
constexpr std::uint64_t kMaxMessage = 1ULL << 40;

[[noreturn]] void fail(const std::string& what) { throw std::runtime_error(what + ": " + std::strerror(errno)); }

// --- socket transfer ---

bool read_all(int fd, void* data, std::size_t size) {
  auto* at = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t n = ::read(fd, at, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

bool write_all(int fd, const void* data, std::size_t size) {
  const auto* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t n = ::send(fd, at, size, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

/// Header of every reply; `size` bytes follow.
struct ReplyHeader {
  std::uint64_t status = 0;
  std::uint64_t size = 0;
};

// --- worker process ---

JobResult do_job(const Work& work, std::uint64_t job) {
  JobResult result;
  try {
    result.bytes = work(job);
  } catch (const OutOfMemory& problem) {
    result.status = JobStatus::kOutOfMemory;
    result.message = problem.what();
  } catch (const std::bad_alloc&) {
    result.status = JobStatus::kOutOfMemory;
    result.message = "out of memory";
  } catch (const std::filesystem::filesystem_error& error) {
    result.status = JobStatus::kFailed;
    result.message = message_of(error);
  } catch (const std::exception& error) {
    result.message = error.what();
    // Libraries report it only in the message text.
    const bool memory = result.message.find("out of memory") != std::string::npos;
    result.status = memory ? JobStatus::kOutOfMemory : JobStatus::kFailed;
  } catch (...) {
    result.status = JobStatus::kFailed;
    result.message = "a module threw something that is no std::exception";
  }
  return result;
}

[[noreturn]] void serve(int fd, const Work& work) {
  std::uint64_t job = 0;
  while (read_all(fd, &job, sizeof job)) {
    const JobResult result = do_job(work, job);
    const std::string& body = result.status == JobStatus::kDone ? result.bytes : result.message;
    const ReplyHeader head{static_cast<std::uint64_t>(result.status), body.size()};
    if (!write_all(fd, &head, sizeof head) || !write_all(fd, body.data(), body.size())) break;
  }
  ::_exit(0);  // skips destructors and buffers, which belong to the parent
}

void prepare_worker(pid_t parent, int log, double memory_limit_mb) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(0);  // the parent exited before prctl()
  ::signal(SIGINT, SIG_IGN);
  ::signal(SIGTERM, SIG_IGN);
  ::signal(SIGHUP, SIG_IGN);
  ::dup2(log, STDOUT_FILENO);
  ::dup2(log, STDERR_FILENO);
  limit_memory(memory_limit_mb);
}

// --- parent process ---

class Fd {
 public:
  explicit Fd(int fd = -1) : fd_(fd) {}
  ~Fd() {
    if (fd_ >= 0) ::close(fd_);
  }
  Fd(const Fd&) = delete;
  Fd& operator=(const Fd&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

/// Last line printed by a worker, shortened.
std::string last_line(int log) {
  // [bytes] Part of the output that is searched for the last line.
  constexpr off_t kTail = 600;
  const off_t size = ::lseek(log, 0, SEEK_END);
  const off_t start = std::max<off_t>(0, size - kTail);
  std::string text(static_cast<std::size_t>(std::max<off_t>(0, size - start)), '\0');
  const ssize_t n = ::pread(log, text.data(), text.size(), start);
  text.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  const std::size_t newline = text.rfind('\n');
  if (newline != std::string::npos) text.erase(0, newline + 1);
  for (char& c : text) c = static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  return text.substr(0, 300);
}

/// One worker process and its current job.
class Worker {
 public:
  Worker(const Work& work, const WorkerPoolOptions& options, const std::vector<std::unique_ptr<Worker>>& others) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) fail("cannot make a socket for a worker");
    socket_ = std::make_unique<Fd>(ends[0]);
    Fd child_end(ends[1]);
    log_ = std::make_unique<Fd>(::memfd_create("worker output", MFD_CLOEXEC));
    if (log_->get() < 0) fail("cannot make a file for a worker's output");
    ::fcntl(log_->get(), F_SETFL, O_APPEND);
    const pid_t parent = ::getpid();
    pid_ = ::fork();
    if (pid_ < 0) fail("cannot start a worker process");
    if (pid_ == 0) {
      // Closes the inherited socket ends of other workers, so that those workers detect the end of the parent.
      for (const auto& other : others) ::close(other->fd());
      ::close(socket_->get());
      prepare_worker(parent, log_->get(), options.memory_limit_mb);
      serve(child_end.get(), work);
    }
  }
  ~Worker() { kill(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  int fd() const { return socket_->get(); }
  bool busy() const { return job_.has_value(); }
  const Job& job() const { return *job_; }
  std::optional<std::uint64_t> group() const { return group_; }
  int num_done() const { return num_done_; }
  double elapsed_s() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  void give(const Job& job) {
    job_ = job;
    group_ = job.group;
    start_ = Clock::now();
    reply_.clear();
    [[maybe_unused]] const int result = ::ftruncate(log_->get(), 0);
    write_all(fd(), &job.id, sizeof job.id);  // a dead worker is detected at the next read
  }

  /// Reads available data. Returns a result when it is complete or the worker has died.
  std::optional<JobResult> receive() {
    char buffer[65536];
    const ssize_t n = ::recv(fd(), buffer, sizeof buffer, MSG_DONTWAIT);
    if (n < 0 && (errno == EINTR || errno == EAGAIN || errno == EWOULDBLOCK)) return std::nullopt;
    if (n <= 0) return end_of_worker();
    reply_.append(buffer, static_cast<std::size_t>(n));
    ReplyHeader head;
    if (reply_.size() < sizeof head) return std::nullopt;
    std::memcpy(&head, reply_.data(), sizeof head);
    if (head.size > kMaxMessage) throw std::logic_error("the reply of a worker process is invalid");
    if (reply_.size() < sizeof head + head.size) return std::nullopt;
    JobResult result = result_of(static_cast<JobStatus>(head.status));
    (result.status == JobStatus::kDone ? result.bytes : result.message) = reply_.substr(sizeof head);
    reply_.clear();
    job_.reset();
    ++num_done_;
    return result;
  }

  JobResult kill_for_time(double limit_s) {
    JobResult result = result_of(JobStatus::kTimedOut);
    kill();
    result.message = fmt::format("exceeded {:g} s of wall time", limit_s);
    return result;
  }

  bool dead() const { return pid_ <= 0; }
  void forget() { job_.reset(); }

  void kill() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    reap();
  }

 private:
  JobResult result_of(JobStatus status) const {
    JobResult result;
    result.id = job_ ? job_->id : 0;
    result.status = status;
    result.wall_s = elapsed_s();
    return result;
  }

  int reap() {
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
    return status;
  }

  JobResult end_of_worker() {
    const int status = reap();
    JobResult result = result_of(JobStatus::kCrashed);
    if (WIFSIGNALED(status)) {
      const int number = WTERMSIG(status);
      result.message = std::string("killed by signal ") + std::to_string(number) + " (" + ::strsignal(number) + ")";
      if (number == SIGKILL) result.message += ", for lack of memory or by another process";
    } else {
      result.message = "the worker ended with status " + std::to_string(WEXITSTATUS(status));
    }
    if (const std::string line = last_line(log_->get()); !line.empty()) result.message += ": " + line;
    return result;
  }

  std::unique_ptr<Fd> socket_;
  std::unique_ptr<Fd> log_;
  pid_t pid_ = -1;
  std::optional<Job> job_;
  std::optional<std::uint64_t> group_;
  int num_done_ = 0;
  Clock::time_point start_;
  std::string reply_;
};

/// Pending jobs by group, in the given order.
class Queue {
 public:
  explicit Queue(const std::vector<Job>& jobs) {
    std::map<std::uint64_t, std::size_t> known;
    for (const Job& job : jobs) {
      const auto [at, fresh] = known.emplace(job.group, groups_.size());
      if (fresh) groups_.emplace_back();
      groups_[at->second].push_back(job);
    }
    for (std::size_t i = 0; i < groups_.size(); ++i) index_[groups_[i].front().group] = i;
    size_ = jobs.size();
  }

  bool empty() const { return size_ == 0; }

  /// The next job for a worker of group `own`; groups in `taken` are other workers'.
  Job take(std::optional<std::uint64_t> own, const std::vector<std::uint64_t>& taken) {
    while (first_ < groups_.size() && groups_[first_].empty()) ++first_;
    std::size_t chosen = first_;
    if (own && !groups_[index_.at(*own)].empty()) {
      chosen = index_.at(*own);
    } else {
      for (std::size_t i = first_; i < groups_.size(); ++i) {
        if (groups_[i].empty() || std::find(taken.begin(), taken.end(), groups_[i].front().group) != taken.end())
          continue;
        chosen = i;
        break;
      }
    }
    const Job job = groups_[chosen].front();
    groups_[chosen].pop_front();
    --size_;
    return job;
  }

 private:
  std::vector<std::deque<Job>> groups_;
  std::map<std::uint64_t, std::size_t> index_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

int num_threads() {
#if defined(__SANITIZE_THREAD__)  // ThreadSanitizer has a thread of its own
  return 1;
#endif
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    if (word != "Threads:") continue;
    int count = 0;
    status >> count;
    return count;
  }
  return 1;
}

class Pool {
 public:
  Pool(const std::vector<Job>& jobs, const Work& work, const WorkerPoolOptions& options, const WorkerPoolEvents& events)
      : queue_(jobs), work_(work), options_(options), events_(events) {}

  bool run() {
    while (!is_finished()) {
      if (options_.canceled && options_.canceled()) return false;
      start_jobs();
      wait();
      receive();
      enforce_time();
    }
    return true;
  }

 private:
  bool is_finished() const { return queue_.empty() && again_.empty() && num_running() == 0; }

  int num_running() const {
    return static_cast<int>(std::count_if(workers_.begin(), workers_.end(), [](const auto& w) { return w->busy(); }));
  }

  void start_jobs() {
    discard_worn_out();
    while (!again_.empty() && num_running() < options_.workers) {
      make_room();
      give(start_worker(), again_.front());
      again_.pop_front();
    }
    for (const auto& worker : workers_) {
      if (!worker->busy() && !queue_.empty()) give(*worker, queue_.take(worker->group(), groups_of_others(*worker)));
    }
    while (!queue_.empty() && static_cast<int>(workers_.size()) < std::max(1, options_.workers)) {
      Worker& worker = start_worker();
      give(worker, queue_.take(std::nullopt, groups_of_others(worker)));
    }
  }

  void discard_worn_out() {
    std::erase_if(workers_, [&](const auto& w) {
      return w->dead() || (!w->busy() && options_.jobs_per_worker > 0 && w->num_done() >= options_.jobs_per_worker);
    });
  }

  // A repeated job needs a fresh worker, for which an idle one is ended.
  void make_room() {
    if (static_cast<int>(workers_.size()) < std::max(1, options_.workers)) return;
    const auto idle = std::find_if(workers_.begin(), workers_.end(), [](const auto& w) { return !w->busy(); });
    if (idle != workers_.end()) workers_.erase(idle);
  }

  Worker& start_worker() {
    if (const int threads = num_threads(); threads != 1) {
      throw std::logic_error("run_jobs() forks and must be called before any thread is started, found " +
                             std::to_string(threads) + " threads");
    }
    workers_.push_back(std::make_unique<Worker>(work_, options_, workers_));
    return *workers_.back();
  }

  void give(Worker& worker, const Job& job) {
    worker.give(job);
    if (events_.started) events_.started(job.id);
  }

  std::vector<std::uint64_t> groups_of_others(const Worker& self) const {
    std::vector<std::uint64_t> groups;
    for (const auto& worker : workers_) {
      if (worker.get() != &self && worker->group()) groups.push_back(*worker->group());
    }
    return groups;
  }

  void wait() {
    std::vector<pollfd> fds;
    for (const auto& worker : workers_) {
      if (worker->busy()) fds.push_back({worker->fd(), POLLIN, 0});
    }
    if (fds.empty()) return;
    const int ready = ::poll(fds.data(), fds.size(), kPollPeriod_ms);
    if (ready < 0 && errno != EINTR) fail("cannot wait for workers");
    const auto now = Clock::now();
    if (events_.idle && now - last_idle_ > std::chrono::milliseconds(kPollPeriod_ms)) {
      last_idle_ = now;
      events_.idle(num_running());
    }
  }

  void receive() {
    for (const auto& worker : workers_) {
      if (!worker->busy()) continue;
      const Job job = worker->job();
      const bool fresh = worker->num_done() == 0;
      if (auto result = worker->receive()) finish(job, fresh, *worker, std::move(*result));
    }
  }

  void finish(const Job& job, bool fresh, Worker& worker, JobResult result) {
    const bool spent = result.status == JobStatus::kCrashed || result.status == JobStatus::kOutOfMemory;
    if (spent) worker.kill();  // its state may be corrupt
    if (spent && !fresh) {
      again_.push_back(job);
    } else if (events_.finished) {
      events_.finished(std::move(result));
    }
    if (spent) worker.forget();
  }

  void enforce_time() {
    if (options_.timeout_s <= 0.0) return;
    for (const auto& worker : workers_) {
      if (!worker->busy() || worker->elapsed_s() < options_.timeout_s) continue;
      JobResult result = worker->kill_for_time(options_.timeout_s);
      worker->forget();
      if (events_.finished) events_.finished(std::move(result));
    }
  }

  Queue queue_;
  std::deque<Job> again_;  // jobs to repeat in a fresh worker
  const Work& work_;
  const WorkerPoolOptions& options_;
  const WorkerPoolEvents& events_;
  std::vector<std::unique_ptr<Worker>> workers_;
  Clock::time_point last_idle_;
};

}  // namespace

const char* name_of(JobStatus status) {
  switch (status) {
    case JobStatus::kDone:
      return "done";
    case JobStatus::kFailed:
      return "failed";
    case JobStatus::kCrashed:
      return "crashed";
    case JobStatus::kTimedOut:
      return "timed_out";
    case JobStatus::kOutOfMemory:
      return "out_of_memory";
  }
  return "";
}

bool run_jobs(const std::vector<Job>& jobs, const Work& work, const WorkerPoolOptions& options,
              const WorkerPoolEvents& events) {
  return Pool(jobs, work, options, events).run();
}

}  // namespace swiftlet::sim
