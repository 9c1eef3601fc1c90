// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/parallel/crew.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <filesystem>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace swiftlet::sim {
namespace {

using namespace std::chrono_literals;

std::vector<pid_t> other_threads() {
  std::vector<pid_t> ids;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    const pid_t id = std::stoi(entry.path().filename());
    if (id != ::gettid()) ids.push_back(id);
  }
  return ids;
}

TEST(Crew, RunsEveryIterationExactlyOnce) {
  for (const int threads : {1, 2, 3, 8}) {
    Crew crew(threads);
    const Crew::Duty duty(crew);
    for (const Sharing sharing : {Sharing::kOwnPart, Sharing::kInOrder}) {
      for (const int count : {0, 1, 2, 7, 100, 70'000}) {
        for (const int at_a_time : {1, 8, 1000}) {
          std::vector<std::atomic<int>> runs(count);
          parallel_for(
              count, at_a_time, [&](int i) { ++runs[i]; }, sharing);
          for (int i = 0; i < count; ++i) ASSERT_EQ(runs[i], 1) << threads << " " << count << " " << at_a_time;
        }
      }
    }
  }
}

TEST(Crew, SuccessiveLoopsSeeEarlierResults) {
  Crew crew(4);
  const Crew::Duty duty(crew);
  std::vector<int> values(64, 0);
  int serial = 0;
  for (int round = 0; round < 20'000; ++round) {
    parallel_for(64, 1, [&](int i) { values[i] += serial; });
    parallel_for(32, 1, [&](int i) { values[i] += values[i + 32]; });
    parallel_for(32, 4, [&](int i) { values[i] -= values[i + 32]; });
    ++serial;
  }
  EXPECT_EQ(values, std::vector<int>(64, 20'000 * (20'000 - 1) / 2));
}

TEST(Crew, HelpersTakePart) {
  Crew crew(3);
  const Crew::Duty duty(crew);
  std::mutex mutex;
  std::set<std::thread::id> seen;
  // Each iteration waits for the other two: a loop on one thread would never end.
  std::atomic<int> here = 0;
  parallel_for(3, 1, [&](int) {
    ++here;
    while (here < 3) std::this_thread::yield();
    const std::lock_guard lock(mutex);
    seen.insert(std::this_thread::get_id());
  });
  EXPECT_EQ(seen.size(), 3U);
}

TEST(Crew, RunsSeriallyOffDutyOrNested) {
  const auto me = std::this_thread::get_id();
  parallel_for(100, 1, [&](int) { ASSERT_EQ(std::this_thread::get_id(), me); });
  Crew crew(4);
  parallel_for(100, 1, [&](int) { ASSERT_EQ(std::this_thread::get_id(), me); });
  const Crew::Duty duty(crew);
  parallel_for(20, 1, [&](int) {
    const auto outer = std::this_thread::get_id();
    parallel_for(20, 1, [&](int) { ASSERT_EQ(std::this_thread::get_id(), outer); });
  });
}

TEST(Crew, RethrowsFirstExceptionAfterAllIterations) {
  for (const int threads : {1, 2, 4}) {
    Crew crew(threads);
    const Crew::Duty duty(crew);
    std::atomic<int> done = 0;
    try {
      parallel_for(200, 3, [&](int i) {
        if (i % 50 == 17) throw std::runtime_error("iteration " + std::to_string(i));
        ++done;
      });
      FAIL() << "nothing was thrown by " << threads << " threads";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "iteration 17");
    }
    EXPECT_EQ(done, 196);
    parallel_for(10, 1, [&](int) { ++done; });
    EXPECT_EQ(done, 206);
  }
}

TEST(Crew, ThreadsEndWithIt) {
  std::thread([] {}).join();  // the thread sanitizer starts a thread of its own together with the first one
  const std::size_t before = other_threads().size();
  {
    Crew crew(4);
    EXPECT_EQ(other_threads().size(), before + 3);
  }
  EXPECT_EQ(other_threads().size(), before);
}

// A helper that the system does not let run, in the hands of the test: it waits in a signal handler.
std::atomic<bool> g_may_run = true;
std::atomic<int> g_stopped = 0;

void stand_still(int) {
  ++g_stopped;
  while (!g_may_run) ::usleep(1000);
}

TEST(Crew, DoesNotWaitForStoppedThreads) {
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the thread sanitizer delivers signals late";
#endif
  Crew crew(4);
  const Crew::Duty duty(crew);
  parallel_for(100, 1, [](int) {});
  std::this_thread::sleep_for(5ms);  // they sleep now
  struct sigaction action {};
  action.sa_handler = stand_still;
  sigaction(SIGUSR1, &action, nullptr);
  g_may_run = false;
  const std::vector<pid_t> helpers = other_threads();
  ASSERT_EQ(helpers.size(), 3U);
  for (const pid_t helper : helpers) syscall(SYS_tgkill, ::getpid(), helper, SIGUSR1);
  while (g_stopped < 3) std::this_thread::yield();

  int done = 0;  // counted by this thread alone
  for (int round = 0; round < 10; ++round) parallel_for(100, 1, [&](int) { ++done; });
  EXPECT_EQ(done, 1000);

  g_may_run = true;
  std::atomic<int> here = 0;  // resumed threads help again
  parallel_for(4, 1, [&](int) {
    ++here;
    while (here < 4) std::this_thread::yield();
  });
  EXPECT_EQ(here, 4);
}

}  // namespace
}  // namespace swiftlet::sim
