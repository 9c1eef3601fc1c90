// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>

// A function in a version for processors with AVX2 and one for all others, chosen when the program starts. Both do the
// same operations, so both give the same bits. Not under sanitizers, whose run time is not there yet by then.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__) && !defined(__AVX2__)
#define SWIFTLET_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define SWIFTLET_VECTOR_CLONES
#endif

/// Eight numbers side by side (vector extension of GCC and Clang, which make of it what the processor has).
namespace swiftlet::lanes {

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
/// All lanes' bits in one number.
[[gnu::always_inline]] inline std::uint64_t union_of(const Ints& v) {
  std::uint64_t words[4];
  std::memcpy(words, &v, sizeof words);
  const std::uint64_t both = words[0] | words[1] | words[2] | words[3];
  return (both | (both >> 32)) & 0xFFFFFFFFU;
}
[[gnu::always_inline]] inline Ints truncated(const Floats& v) { return __builtin_convertvector(v, Ints); }
[[gnu::always_inline]] inline Floats to_float(const Ints& v) { return __builtin_convertvector(v, Floats); }

}  // namespace swiftlet::lanes
