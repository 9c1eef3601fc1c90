// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <limits>
#include <mutex>

namespace swiftlet::sim {

/// An exception must not leave a thread: the program would end without a word. So every part of a loop that threads
/// share runs guarded, and what was thrown is thrown again after it. parallel_for (sim/parallel/crew.hpp) does so by
/// iteration; who wants it by another number has a FirstException of his own in the loop.
///
/// All parts run, and of several exceptions that of the first part is kept, so the outcome is the same for any number
/// of threads.
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
  /// Throws what is kept, if anything.
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
