// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/parallel/crew.hpp"

#include <immintrin.h>  // x86 only

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <system_error>
#include <thread>
#include <vector>

namespace swiftlet::sim {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;

// Busy wait of an idle helper for the next loop before it sleeps. Longer than most intervals between the loops of a
// tick, much shorter than a time slice of the scheduler. Larger values waste processor time, smaller ones delay the
// next loop.
constexpr microseconds kSpinForALoop{100};
// Busy wait of the caller for the last parts of a loop before it sleeps. Waking a thread takes about as long as a part,
// some tens of microseconds. Larger values waste processor time, smaller ones delay the end of loops.
constexpr microseconds kSpinForAPart{50};
// [-] Pauses between readings of the clock. Larger values exceed the time limit of a busy wait by more.
constexpr int kPausesPerLook = 32;

thread_local Crew* t_crew = nullptr;

/// Busy-waits until the condition holds or the time limit is reached.
template <class Condition>
bool spin_until(microseconds limit, const Condition& is_true) {
  const auto end = Clock::now() + limit;
  do {
    for (int i = 0; i < kPausesPerLook; ++i) {
      if (is_true()) return true;
      _mm_pause();
    }
  } while (Clock::now() < end);
  return false;
}

/// A range of consecutive untaken parts of a loop, in one atomic word. The word includes the loop's number, so that a
/// stale value cannot take parts of a later loop.
class alignas(64) Parts {
 public:
  /// [-] Largest number of parts of a loop: begin and end have 16 bits each.
  static constexpr int kMax = 0xFFFF;

  void put(std::uint32_t loop, int begin, int end) { word_.store(joined(loop, begin, end), std::memory_order_release); }

  /// Takes one part; -1: none left.
  int take_first() { return take<true>(); }
  int take_last() { return take<false>(); }

 private:
  static std::uint64_t joined(std::uint64_t loop, int begin, int end) {
    return loop << 32 | static_cast<std::uint64_t>(begin) << 16 | static_cast<std::uint64_t>(end);
  }

  template <bool kFirst>
  int take() {
    std::uint64_t seen = word_.load(std::memory_order_acquire);
    for (;;) {
      const int begin = static_cast<int>(seen >> 16 & kMax), end = static_cast<int>(seen & kMax);
      if (begin >= end) return -1;
      const std::uint64_t left = kFirst ? seen + (1U << 16) : seen - 1;
      if (word_.compare_exchange_weak(seen, left, std::memory_order_acq_rel, std::memory_order_acquire)) {
        return kFirst ? begin : end - 1;
      }
    }
  }

  std::atomic<std::uint64_t> word_{0};
};

}  // namespace

class Crew::Impl {
 public:
  explicit Impl(int num_helpers);
  ~Impl();

  bool has_helpers() const { return !helpers_.empty(); }
  void run(int count, int at_a_time, Sharing sharing, void* loop, Work work);

 private:
  /// The current loop. Written by the caller only while no part is taken or executed.
  struct Loop {
    std::atomic<void*> loop{nullptr};
    std::atomic<Work> work{nullptr};
    std::atomic<int> count{0};
    std::atomic<int> at_a_time{1};
    std::atomic<bool> in_order{false};
  };

  void share(int num_parts);
  void call_helpers(int num_parts);
  bool do_a_part(int member);
  int take_a_part(int member);
  void help(int member);

  alignas(64) Loop loop_;
  std::uint32_t loop_number_ = 0;
  std::vector<Parts> untaken_;  // indexed by member; the caller is number 0
  alignas(64) std::atomic<std::uint32_t> calls_{0};
  std::atomic<bool> over_{false};
  alignas(64) std::atomic<std::int32_t> done_by_helpers_{0};  // completed parts of the loop
  std::vector<std::thread> helpers_;
};

// ---- caller ----

Crew::Impl::Impl(int num_helpers) : untaken_(num_helpers + 1) {
  for (int i = 1; i <= num_helpers; ++i) {
    try {
      helpers_.emplace_back([this, i] { help(i); });
    } catch (const std::system_error&) {
      break;
    }
  }
}

Crew::Impl::~Impl() {
  over_ = true;
  ++calls_;
  calls_.notify_all();
  for (std::thread& helper : helpers_) helper.join();
}

void Crew::Impl::run(int count, int at_a_time, Sharing sharing, void* loop, Work work) {
  at_a_time = std::max(at_a_time, (count - 1) / Parts::kMax + 1);
  const int num_parts = (count - 1) / at_a_time + 1;
  loop_.loop.store(loop, std::memory_order_relaxed);
  loop_.work.store(work, std::memory_order_relaxed);
  loop_.count.store(count, std::memory_order_relaxed);
  loop_.at_a_time.store(at_a_time, std::memory_order_relaxed);
  loop_.in_order.store(sharing == Sharing::kInOrder, std::memory_order_relaxed);
  done_by_helpers_.store(0, std::memory_order_relaxed);
  share(num_parts);
  call_helpers(num_parts);

  int done_here = 0;
  while (do_a_part(0)) ++done_here;
  const int done_elsewhere = num_parts - done_here;
  const auto all_done = [&] { return done_by_helpers_.load(std::memory_order_acquire) == done_elsewhere; };
  if (spin_until(kSpinForAPart, all_done)) return;
  for (int done = 0; (done = done_by_helpers_.load(std::memory_order_acquire)) != done_elsewhere;) {
    done_by_helpers_.wait(done, std::memory_order_acquire);
  }
}

void Crew::Impl::share(int num_parts) {
  ++loop_number_;
  const int num_members = loop_.in_order.load(std::memory_order_relaxed) ? 1 : static_cast<int>(untaken_.size());
  for (int m = 0; m < num_members; ++m) {
    untaken_[m].put(loop_number_, num_parts * m / num_members, num_parts * (m + 1) / num_members);
  }
}

void Crew::Impl::call_helpers(int num_parts) {
  ++calls_;
  const int wanted = std::min(num_parts - 1, static_cast<int>(helpers_.size()));
  for (int i = 0; i < wanted; ++i) calls_.notify_one();
}

// ---- caller and helpers ----

bool Crew::Impl::do_a_part(int member) {
  const int part = take_a_part(member);
  if (part < 0) return false;
  const int at_a_time = loop_.at_a_time.load(std::memory_order_relaxed);
  const int begin = part * at_a_time;
  const int end = std::min(begin + at_a_time, loop_.count.load(std::memory_order_relaxed));
  loop_.work.load(std::memory_order_relaxed)(loop_.loop.load(std::memory_order_relaxed), begin, end);
  return true;
}

// Takes own parts from the front, parts of other members from the back, which their owner reaches last. With kInOrder,
// all parts belong to the caller. Loop data read before a part is taken affects only the order of the work.
int Crew::Impl::take_a_part(int member) {
  if (const int part = untaken_[member].take_first(); part >= 0) return part;
  if (loop_.in_order.load(std::memory_order_relaxed)) return untaken_[0].take_first();
  const int num_members = static_cast<int>(untaken_.size());
  for (int k = 1; k < num_members; ++k) {
    if (const int part = untaken_[(member + k) % num_members].take_last(); part >= 0) return part;
  }
  return -1;
}

// ---- helpers ----

void Crew::Impl::help(int member) {
  for (;;) {
    const std::uint32_t call = calls_.load();
    while (do_a_part(member)) {
      done_by_helpers_.fetch_add(1, std::memory_order_acq_rel);
      done_by_helpers_.notify_one();
    }
    if (over_) return;
    const auto is_called = [&] { return calls_.load(std::memory_order_relaxed) != call; };
    if (!spin_until(kSpinForALoop, is_called)) calls_.wait(call);
  }
}

Crew::Crew(int threads) : num_threads_(std::max(threads, 1)), impl_(std::make_unique<Impl>(num_threads_ - 1)) {}
Crew::~Crew() = default;

Crew::Duty::Duty(Crew& crew) : before_(t_crew) { t_crew = &crew; }
Crew::Duty::~Duty() { t_crew = before_; }

void Crew::share_out(int count, int at_a_time, Sharing sharing, void* loop, Work work) {
  if (count <= 0) return;
  Crew* const crew = t_crew;
  if (crew == nullptr || !crew->impl_->has_helpers() || count <= at_a_time) {
    work(loop, 0, count);
    return;
  }
  t_crew = nullptr;  // loops nested in this one run serially
  crew->impl_->run(count, at_a_time, sharing, loop, work);
  t_crew = crew;
}

}  // namespace swiftlet::sim
