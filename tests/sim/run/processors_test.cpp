// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/run/processors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "sim/run/control_groups.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/run/memory.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

/// Variables of the environment that are as before when the test ends.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* old = std::getenv(name)) before_ = old;
    had_ = std::getenv(name) != nullptr;
    value == nullptr ? unsetenv(name) : setenv(name, value, 1);
  }
  ~Variable() { had_ ? setenv(name_, before_.c_str(), 1) : unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::string before_;
  bool had_ = false;
};

/// The folders proc and sys of a machine.
class Machine {
 public:
  Machine& write(const std::string& file, const std::string& text) {
    const fs::path path = folder_.path() / file;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
    return *this;
  }
  Machine& groups(const std::string& text) { return write("proc/self/cgroup", text); }
  ControlGroupLimits limits() const { return control_group_limits(folder_.path()); }

 private:
  TemporaryDirectory folder_;
};

TEST(Processors, AreNotMoreThanSlurmGives) {
  const Variable no_task("SLURM_CPUS_PER_TASK", nullptr), no_node("SLURM_CPUS_ON_NODE", nullptr);
  const int all = available_processors();
  EXPECT_GE(all, 1);
  EXPECT_LE(all, static_cast<int>(std::thread::hardware_concurrency()));
  for (const char* name : {"SLURM_CPUS_PER_TASK", "SLURM_CPUS_ON_NODE"}) {
    for (const auto& [given, expected] :
         {std::pair("1", 1), {"0", all}, {"-1", all}, {"1000000", all}, {"99999999999", all}, {"x", all}}) {
      const Variable variable(name, given);
      EXPECT_EQ(available_processors(), expected) << name << " " << given;
    }
  }
}

TEST(Memory, IsNotMoreThanSlurmGives) {
  const Variable no_cpus("SLURM_CPUS_ON_NODE", nullptr), no_node("SLURM_MEM_PER_NODE", nullptr),
      no_cpu("SLURM_MEM_PER_CPU", nullptr);
  const double all = available_memory_bytes();
  {
    const Variable node("SLURM_MEM_PER_NODE", "100");
    EXPECT_EQ(available_memory_bytes(), 100.0 * 1024 * 1024);
  }
  {
    const Variable cpu("SLURM_MEM_PER_CPU", "50"), cpus("SLURM_CPUS_ON_NODE", "3");
    EXPECT_EQ(available_memory_bytes(), 150.0 * 1024 * 1024);
  }
  const Variable whole_node("SLURM_MEM_PER_NODE", "0");  // 0 stands for the whole memory
  EXPECT_EQ(available_memory_bytes(), all);
}

TEST(ControlGroups, WithoutThemThereIsNoLimit) {
  Machine machine;
  EXPECT_TRUE(std::isinf(machine.limits().processors));
  EXPECT_TRUE(std::isinf(machine.limits().memory_bytes));
  machine.groups("0::/\n").write("sys/fs/cgroup/cpu.max", "max 100000\n").write("sys/fs/cgroup/memory.max", "max\n");
  EXPECT_TRUE(std::isinf(machine.limits().processors));
  EXPECT_TRUE(std::isinf(machine.limits().memory_bytes));
}

TEST(ControlGroups, OfAContainerOfVersion2) {
  Machine machine;
  machine.groups("0::/\n")
      .write("sys/fs/cgroup/cpu.max", "150000 100000\n")
      .write("sys/fs/cgroup/memory.max", "1073741824\n");
  EXPECT_DOUBLE_EQ(machine.limits().processors, 1.5);
  EXPECT_DOUBLE_EQ(machine.limits().memory_bytes, 1073741824.0);
}

// A job of Slurm: the limits stand at several levels above the group of the task, and the least of them counts.
TEST(ControlGroups, Version2LimitsCoverNestedGroups) {
  Machine machine;
  const std::string job = "sys/fs/cgroup/system.slice/slurmstepd.scope/job_12/";
  machine.groups("0::/system.slice/slurmstepd.scope/job_12/step_0/user/task_0\n")
      .write(job + "memory.max", "4000000\n")
      .write(job + "step_0/memory.max", "3000000\n")
      .write(job + "step_0/user/task_0/memory.max", "max\n")
      .write(job + "step_0/user/task_0/cpu.max", "400000 100000\n")
      .write(job + "cpu.max", "200000 100000\n");
  EXPECT_DOUBLE_EQ(machine.limits().processors, 2.0);
  EXPECT_DOUBLE_EQ(machine.limits().memory_bytes, 3000000.0);
}

TEST(ControlGroups, OfVersion1) {
  Machine machine;
  machine.groups("5:memory:/slurm/uid_0/job_1\n4:cpu,cpuacct:/slurm/uid_0\n1:name=systemd:/\n")
      .write("sys/fs/cgroup/memory/slurm/uid_0/job_1/memory.limit_in_bytes", "2000000\n")
      .write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n")
      .write("sys/fs/cgroup/cpu,cpuacct/slurm/uid_0/cpu.cfs_quota_us", "250000\n")
      .write("sys/fs/cgroup/cpu,cpuacct/slurm/uid_0/cpu.cfs_period_us", "50000\n")
      .write("sys/fs/cgroup/cpu,cpuacct/cpu.cfs_quota_us", "-1\n")
      .write("sys/fs/cgroup/cpu,cpuacct/cpu.cfs_period_us", "100000\n");
  EXPECT_DOUBLE_EQ(machine.limits().processors, 5.0);
  EXPECT_DOUBLE_EQ(machine.limits().memory_bytes, 2000000.0);
}

// Docker without a namespace of control groups: the path is the host's, the mount shows the container's group alone.
TEST(ControlGroups, HandleAContainerWithHostPath) {
  Machine machine;
  machine.groups("5:memory:/docker/0123\n4:cpu,cpuacct:/docker/0123\n")
      .write("sys/fs/cgroup/memory/memory.limit_in_bytes", "700000\n")
      .write("sys/fs/cgroup/cpu/cpu.cfs_quota_us", "100000\n")
      .write("sys/fs/cgroup/cpu/cpu.cfs_period_us", "100000\n");
  EXPECT_DOUBLE_EQ(machine.limits().processors, 1.0);
  EXPECT_DOUBLE_EQ(machine.limits().memory_bytes, 700000.0);
}

TEST(ControlGroups, OddTextIsNoLimit) {
  Machine machine;
  machine.groups("\nx\n0::\n0::/../../up\n")
      .write("sys/fs/cgroup/cpu.max", "x y\n")
      .write("sys/fs/cgroup/memory.max", "-5\n");
  EXPECT_TRUE(std::isinf(machine.limits().processors));
  EXPECT_TRUE(std::isinf(machine.limits().memory_bytes));
}

TEST(Threads, FollowOpenMpUpTo1024) {
  const int before = omp_get_max_threads();
  const Variable set("OMP_NUM_THREADS", "3000");
  omp_set_num_threads(1024);
  EXPECT_EQ(default_threads(), 1024);
  omp_set_num_threads(1025);
  try {
    default_threads();
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "OMP_NUM_THREADS: expected a whole number in [1, 1024], found 1025");
  }
  // A number for one run does not make OpenMP's own loops smaller.
  EXPECT_THROW(Simulation(Scenario(), 1), InputError);
  omp_set_num_threads(before);
  EXPECT_THROW(Simulation(Scenario(), 1025), InputError);
}

TEST(Threads, MatchProcessorsUnlessOpenMpOverrides) {
  const int before = omp_get_max_threads();
  const Variable not_set("OMP_NUM_THREADS", nullptr);
  omp_set_num_threads(500);
  EXPECT_EQ(default_threads(), std::min(500, available_processors()));
  omp_set_num_threads(before);
}

}  // namespace
}  // namespace swiftlet::sim
