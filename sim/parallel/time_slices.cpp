// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/parallel/time_slices.hpp"

#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>

namespace swiftlet::sim {
namespace {

/// Argument of sched_setattr(2), for which the C library has no declaration.
struct SchedulingAttributes {
  std::uint32_t size = sizeof(SchedulingAttributes);
  std::uint32_t policy = 0;
  std::uint64_t flags = 0;
  std::int32_t nice = 0;
  std::uint32_t priority = 0;
  std::uint64_t runtime_ns = 0;  // the time slice under the default policies
  std::uint64_t deadline_ns = 0;
  std::uint64_t period_ns = 0;
};

constexpr std::uint64_t kShortest_ns = 100'000;
constexpr std::uint64_t kUsual = 0;

void ask_for(std::uint64_t slice_ns) {
  SchedulingAttributes attributes;
  if (::syscall(SYS_sched_getattr, 0, &attributes, sizeof attributes, 0U) != 0) return;
  if (attributes.policy != SCHED_OTHER && attributes.policy != SCHED_BATCH) return;
  attributes.runtime_ns = slice_ns;
  ::syscall(SYS_sched_setattr, 0, &attributes, 0U);
}

}  // namespace

void ask_for_short_time_slices() { ask_for(kShortest_ns); }
void ask_for_usual_time_slices() { ask_for(kUsual); }

}  // namespace swiftlet::sim
