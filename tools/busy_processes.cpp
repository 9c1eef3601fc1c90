// SPDX-License-Identifier: BSD-3-Clause
#include "busy_processes.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <ctime>

#include "swiftlet/sim/parallel/time_slices.hpp"

namespace swiftlet::tools {
namespace {

[[noreturn]] void compute() {
  for (volatile double x = 1.0;;) x = x * 1.0000001;
}

}  // namespace

BusyProcesses::BusyProcesses(int count) {
  const pid_t parent = ::getpid();
  for (int i = 0; i < count; ++i) {
    const pid_t id = ::fork();
    if (id == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (::getppid() != parent) ::_exit(0);  // the parent exited before prctl()
      sim::ask_for_usual_time_slices();
      compute();
    }
    if (id > 0) ids_.push_back(id);
  }
}

BusyProcesses::~BusyProcesses() {
  for (const pid_t id : ids_) {
    ::kill(id, SIGKILL);
    ::waitpid(id, nullptr, 0);
  }
}

double BusyProcesses::cpu_s() const {
  double sum_s = 0.0;
  for (const pid_t id : ids_) {
    clockid_t clock = 0;
    timespec time{};
    if (::clock_getcpuclockid(id, &clock) != 0 || ::clock_gettime(clock, &time) != 0) continue;
    sum_s += static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  return sum_s;
}

}  // namespace swiftlet::tools
