// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/sim/parallel/first_exception.hpp"

namespace swiftlet::sim {

/// Who takes which iterations of a loop.
enum class Sharing {
  /// Each thread begins with a part of its own, the same in all loops of a length, and then helps the others. What it
  /// has touched in one loop is still in its caches in the next.
  kOwnPart,
  /// In the order of the loop, whoever comes.
  kInOrder
};

/// Threads that share the loops of a run. Whoever runs takes the next few iterations that nobody has taken. So a loop
/// waits for work that somebody has begun, and never for a thread that the system lets wait. Beside other programs the
/// caller does alone what nobody helps with. A parallel region of OpenMP waits at both of its ends until every thread
/// of it has run, however little there was to do.
///
/// Threads that find nothing to do spin for a moment, because the next loop mostly comes soon, and then sleep.
class Crew {
 public:
  /// @param threads  how many work on a loop, its caller among them. Where the system denies some, the rest do it all.
  explicit Crew(int threads);
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  /// As asked for.
  int num_threads() const { return num_threads_; }

  /// While it lives, this crew helps with the loops of the thread that made it. One thread at a time.
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

/// Calls act(i) for all 0 <= i < count; threads take `at_a_time` neighbors each. Alone where no crew is on duty, and
/// within another loop. All iterations run even if some throw; then the exception of the first one is thrown.
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
