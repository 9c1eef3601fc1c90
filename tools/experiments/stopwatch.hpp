// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <ctime>
#include <vector>

namespace swiftlet::tools {

/// Processor time of this thread, without that of other programs.
inline double thread_time_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Processor time of each call.
class Stopwatch {
 public:
  template <class Work>
  void time(Work&& work) {
    const double start = thread_time_s();
    work();
    add(thread_time_s() - start);
  }
  void add(double took_s) { times_ms_.push_back(1e3 * took_s); }
  const std::vector<double>& times_ms() const { return times_ms_; }
  /// Lower median; 0 without samples.
  double median_ms() const {
    if (times_ms_.empty()) return 0.0;
    std::vector<double> sorted = times_ms_;
    std::sort(sorted.begin(), sorted.end());
    return sorted[(sorted.size() - 1) / 2];
  }

 private:
  std::vector<double> times_ms_;
};

}  // namespace swiftlet::tools
