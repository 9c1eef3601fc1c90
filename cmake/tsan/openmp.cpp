// SPDX-License-Identifier: BSD-3-Clause
// Tells the thread sanitizer what it cannot see: that a parallel region begins after what came before it and ends
// before what comes after. Debian's libgomp is not instrumented, and without this every region looks like a race.
// Linked into the preset "tsan" only, in the place of libgomp's entry points (-Wl,--wrap; Options.cmake names them).
// Two iterations of one loop stay unordered, so real races between them are still found (tests/house/tsan_probe.cpp).
#include <sanitizer/tsan_interface.h>

namespace {

struct Region {
  void (*body)(void*);
  void* data;
  // Two marks: with one, a thread that begins after another one's end would count as ordered after it.
  char begin = 0;
  alignas(8) char end = 0;
};

void run_thread(void* pointer) {
  auto* region = static_cast<Region*>(pointer);
  __tsan_acquire(&region->begin);
  region->body(region->data);
  __tsan_release(&region->end);
}

}  // namespace

// One wrapper for each way in which GCC starts a region: plain, and in one with the loop inside it.
#define WRAP_LOOP(name)                                                                                      \
  void __real_##name(void (*)(void*), void*, unsigned, long, long, long, long, unsigned);                    \
  void __wrap_##name(void (*body)(void*), void* data, unsigned num_threads, long start, long end, long step, \
                     long chunk, unsigned flags) {                                                           \
    Region region{.body = body, .data = data};                                                               \
    __tsan_release(&region.begin);                                                                           \
    __real_##name(run_thread, &region, num_threads, start, end, step, chunk, flags);                         \
    __tsan_acquire(&region.end);                                                                             \
  }

extern "C" {

void __real_GOMP_parallel(void (*body)(void*), void* data, unsigned num_threads, unsigned flags);

void __wrap_GOMP_parallel(void (*body)(void*), void* data, unsigned num_threads, unsigned flags) {
  Region region{.body = body, .data = data};
  __tsan_release(&region.begin);
  __real_GOMP_parallel(run_thread, &region, num_threads, flags);
  __tsan_acquire(&region.end);
}

WRAP_LOOP(GOMP_parallel_loop_dynamic)
WRAP_LOOP(GOMP_parallel_loop_guided)
WRAP_LOOP(GOMP_parallel_loop_nonmonotonic_dynamic)
WRAP_LOOP(GOMP_parallel_loop_nonmonotonic_guided)

}  // extern "C"
