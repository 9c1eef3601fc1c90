// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/sim/parallel/first_exception.hpp"

namespace swiftlet::sim {

/// Assignment of the iterations of a loop to threads.
enum class Sharing {
  /// Each thread begins with its own part, the same one in all loops of equal length, and then helps the others. Data
  /// used in one loop is still in the thread's caches in the next.
  kOwnPart,
  /// In the order of the loop, each part by the next idle thread.
  kInOrder
};

/// Threads that share the loops of a run. Each running thread repeatedly takes the next few unassigned iterations. A
/// loop therefore waits only for iterations that a thread has begun, never for a thread that the system has suspended
/// before that. When other programs occupy the processors, the caller performs all iterations that no helper takes. A
/// parallel region of OpenMP, in contrast, waits at both ends until each of its threads has run, however little work
/// there is.
///
/// Idle threads spin briefly, because the next loop usually follows soon, and then sleep.
class Crew {
 public:
  /// @param threads  number of threads per loop, including the caller. If the system denies some, the others do all
  /// work.
  explicit Crew(int threads);
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  /// The requested number.
  int num_threads() const { return num_threads_; }

  /// While it exists, this crew helps with the loops of the thread that created it. Only one thread at a time.
  class Duty {
   public:
    explicit Duty(Crew& crew);
    ~Duty();
    Duty(const Duty&) = delete;
    Duty& operator=(const Duty&) = delete;

   private:
    Crew* before_;
  };

  /// Iterations [begin, end) of a loop.
  using Work = void (*)(void* loop, int begin, int end);
  static void share_out(int count, int at_a_time, Sharing sharing, void* loop, Work work);

 private:
  class Impl;
  int num_threads_;
  std::unique_ptr<Impl> impl_;
};

/// Calls act(i) for all 0 <= i < count; each thread takes `at_a_time` consecutive iterations at once. Serial without a
/// crew on duty and within another loop. All iterations run even if some throw; then the exception of the lowest
/// iteration is rethrown.
template <class Act>
void parallel_for(int count, int at_a_time, const Act& act, Sharing sharing = Sharing::kOwnPart) {
  struct Loop {
    const Act& act;
    FirstException failure;
  } loop{act, {}};
  Crew::share_out(count, at_a_time, sharing, &loop, [](void* pointer, int begin, int end) {
    auto& of = *static_cast<Loop*>(pointer);
    for (int i = begin; i < end; ++i) of.failure.guard(i, [&] { of.act(i); });
  });
  loop.failure.rethrow();
}

}  // namespace swiftlet::sim
