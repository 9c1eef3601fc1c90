// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>

// Compiles a function for AVX2 and for all other processors; the version is chosen at program start. Both do the same
// operations and give the same bits. Not under sanitizers, whose runtime is not initialized yet at that time.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__) && !defined(__AVX2__)
#define SWIFTLET_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define SWIFTLET_VECTOR_CLONES
#endif

/// Vectors of eight numbers (vector extension of GCC and Clang, compiled to the instructions of the processor).
namespace swiftlet::lanes {

/// [-] Numbers in a vector.
inline constexpr int kLanes = 8;
using Floats = float __attribute__((vector_size(32)));
using Ints = std::int32_t __attribute__((vector_size(32)));

template <class Vector, class Number>
[[gnu::always_inline]] inline Vector load(const Number* from) {
  Vector v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
template <class Vector, class Number>
[[gnu::always_inline]] inline void store(const Vector& v, Number* to) {
  std::memcpy(to, &v, sizeof v);
}
[[gnu::always_inline]] inline Floats max(const Floats& a, const Floats& b) { return a > b ? a : b; }
[[gnu::always_inline]] inline Floats min(const Floats& a, const Floats& b) { return a < b ? a : b; }
/// Bitwise OR of all lanes.
[[gnu::always_inline]] inline std::uint64_t union_of(const Ints& v) {
  std::uint64_t words[4];
  std::memcpy(words, &v, sizeof words);
  const std::uint64_t both = words[0] | words[1] | words[2] | words[3];
  return (both | (both >> 32)) & 0xFFFFFFFFU;
}
[[gnu::always_inline]] inline Ints truncated(const Floats& v) { return __builtin_convertvector(v, Ints); }
[[gnu::always_inline]] inline Floats to_float(const Ints& v) { return __builtin_convertvector(v, Floats); }

}  // namespace swiftlet::lanes
