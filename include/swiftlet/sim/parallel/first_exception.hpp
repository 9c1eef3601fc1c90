// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <limits>
#include <mutex>

namespace swiftlet::sim {

/// An exception that leaves a thread ends the program without a message. Every part of a loop shared by threads
/// therefore runs guarded, and its exception is rethrown after the loop. parallel_for (sim/parallel/crew.hpp) does so
/// by iteration; loops that order their parts differently use a FirstException of their own.
///
/// All parts run, and of several exceptions that of the first part is kept, so the outcome does not depend on the
/// number of threads.
class FirstException {
 public:
  template <class Act>
  void guard(int part, const Act& act) noexcept {
    try {
      act();
    } catch (...) {
      keep(part);
    }
  }

  /// The part whose exception is kept; -1: none was thrown.
  int part() const { return exception_ ? part_ : -1; }
  /// Rethrows the kept exception, if any.
  void rethrow() const {
    if (exception_) std::rethrow_exception(exception_);
  }

 private:
  void keep(int part) noexcept;

  std::mutex mutex_;
  std::exception_ptr exception_;
  int part_ = std::numeric_limits<int>::max();
};

}  // namespace swiftlet::sim
