// SPDX-License-Identifier: BSD-3-Clause
#include "beside_others.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <ctime>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "busy_processes.hpp"
#include "scratch_folder.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::tools {
namespace {

namespace fs = std::filesystem;

constexpr double kSettle_s = 0.5;
constexpr int kTurns = 20;      // turns of each of the two simulations
constexpr int kBatchTurns = 3;  // turns of each of the two batches
constexpr int kEpisodes = 8;    // episodes per turn
constexpr double kEpisode_s = 150.0;

/// Time used so far by one of two alternating runs of equal work.
struct Spent {
  double wall_s = 0.0;
  double own_cpu_s = 0.0;
  double others_cpu_s = 0.0;

  friend Spent operator-(const Spent& a, const Spent& b) {
    return {a.wall_s - b.wall_s, a.own_cpu_s - b.own_cpu_s, a.others_cpu_s - b.others_cpu_s};
  }
  Spent& operator+=(const Spent& b) { return *this = *this - Spent{-b.wall_s, -b.own_cpu_s, -b.others_cpu_s}; }
};

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

Spent spent(const BusyProcesses& others, int whose) {
  rusage own{};
  ::getrusage(whose, &own);
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  return {wall_s, seconds_of(own.ru_utime) + seconds_of(own.ru_stime), others.cpu_s()};
}

BesideOthers compare(const Spent& by_one, const Spent& by_all, int threads, int others) {
  const double fair_s = (by_all.own_cpu_s + by_all.others_cpu_s) * threads / (threads + others);
  return {threads, others, by_one.wall_s / by_all.wall_s, by_one.own_cpu_s / fair_s};
}

void fly_until(sim::Simulation& simulation, double until_s) {
  while (to_seconds(simulation.now()) < until_s) simulation.tick();
}

/// Runs this program in a new process.
void run_swiftlet(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "swiftlet");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_t id = 0;
  int status = 0;
  if (::posix_spawn(&id, "/proc/self/exe", nullptr, nullptr, argv.data(), environ) != 0 ||
      ::waitpid(id, &status, 0) != id || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw std::runtime_error("bench: a batch has failed");
  }
}

}  // namespace

BesideOthers fly_beside_others(const sim::Scenario& scenario, double turn_s, int threads,
                               const ProgressCallback& report_progress) {
  const BusyProcesses others(threads);
  const sim::World world = sim::build_world(scenario.world, scenario.seed_of_world());
  sim::Simulation by_one(scenario, 1, world), by_all(scenario, threads, world);
  fly_until(by_one, kSettle_s);
  fly_until(by_all, kSettle_s);
  Spent one, all;
  for (int turn = 1; turn <= kTurns; ++turn) {
    const double until_s = kSettle_s + turn * turn_s;
    const Spent before = spent(others, RUSAGE_SELF);
    fly_until(by_one, until_s);
    const Spent between = spent(others, RUSAGE_SELF);
    fly_until(by_all, until_s);
    one += between - before;
    all += spent(others, RUSAGE_SELF) - between;
    report_progress(static_cast<double>(turn) / kTurns);
  }
  if (by_one.state_hash() != by_all.state_hash()) throw std::logic_error("bench: one thread and all fly differently");
  return compare(one, all, threads, others.count());
}

BesideOthers fly_batch_beside_others(int workers, const ProgressCallback& report_progress) {
  const BusyProcesses others(workers);
  const ScratchFolder folder;
  const fs::path file = folder / "batch.yaml";
  sim::write_file(file, "name: busy\nscenario: bench_crowd\nset: {duration_s: " + std::to_string(kEpisode_s) +
                            "}\nseeds: {count: " + std::to_string(kEpisodes) + "}\n");
  Spent one, all;
  for (int turn = 1; turn <= kBatchTurns; ++turn) {
    for (const bool alone : {true, false}) {
      const std::string out = folder / (std::to_string(turn) + (alone ? "_one" : "_all"));
      const Spent before = spent(others, RUSAGE_CHILDREN);
      run_swiftlet({"batch", file, "--out", out, "--quiet", "--jobs", std::to_string(alone ? 1 : workers)});
      (alone ? one : all) += spent(others, RUSAGE_CHILDREN) - before;
      report_progress((turn - (alone ? 0.5 : 0.0)) / kBatchTurns);
    }
  }
  return compare(one, all, workers, others.count());
}

}  // namespace swiftlet::tools
