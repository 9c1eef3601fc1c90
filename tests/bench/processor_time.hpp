// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ctime>

namespace swiftlet {

/// Processor time of this thread; other processes do not count.
inline double processor_time_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Processor time of a function.
template <class Work>
double time_of_s(Work&& work) {
  const double start = processor_time_s();
  work();
  return processor_time_s() - start;
}

}  // namespace swiftlet
