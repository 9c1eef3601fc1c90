// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Visitor that records which bytes of a value belong to its fields.
class BytesVisited {
 public:
  BytesVisited(const void* start, std::size_t size) : start_(static_cast<const std::byte*>(start)), visited_(size) {}

  void time(const char*, const TimeNs& value, const char*) { mark(value); }
  void valid(const char*, const bool& value, const char*) { mark(value); }
  void vehicle(const char*, const VehicleId& value, const char*) { mark(value); }
  void field(const char*, const auto& value, const char*) { mark(value); }
  void choice(const char*, const auto& value, std::span<const char* const>, const char*) { mark(value); }
  void covariance(const char*, const auto& value, const char*) { mark(value); }
  void array(const char*, const auto& value, const char*) { mark(value); }
  void list(const char*, const auto& value, const char*) { mark(value); }

  bool operator[](std::size_t i) const { return visited_[i]; }

 private:
  void mark(const auto& value) {
    const auto from = reinterpret_cast<const std::byte*>(std::addressof(value)) - start_;
    for (std::size_t i = 0; i < sizeof value; ++i) visited_.at(from + i) = true;
  }

  const std::byte* start_;
  std::vector<bool> visited_;
};

/// Does the compiler report padding bytes? GCC does; with clang 14 nothing is compared.
#if __has_builtin(__builtin_clear_padding)
#define SWIFTLET_CLEAR_PADDING(pointer) __builtin_clear_padding(pointer)
inline constexpr bool kPaddingIsKnown = true;
#else
#define SWIFTLET_CLEAR_PADDING(pointer) static_cast<void>(pointer)
inline constexpr bool kPaddingIsKnown = false;
#endif

/// 1 for the bytes of a type that are not padding.
template <class Kind>
std::array<unsigned char, sizeof(Kind)> bytes_of_fields() {
  std::array<unsigned char, sizeof(Kind)> bytes;
  Kind value{};
  std::destroy_at(&value);
  std::memset(static_cast<void*>(&value), 1, sizeof value);
  SWIFTLET_CLEAR_PADDING(&value);
  std::memcpy(bytes.data(), static_cast<const void*>(&value), sizeof value);
  new (&value) Kind{};
  return bytes;
}

/// Number of bytes in fields that `visit` does not name.
template <class Kind>
int num_bytes_forgotten() {
  const Kind value{};
  BytesVisited visited(&value, sizeof value);
  Kind::visit(value, visited);
  const auto fields = bytes_of_fields<Kind>();
  int num = 0;
  for (std::size_t i = 0; i < sizeof value; ++i) num += fields[i] != 0 && !visited[i];
  return num;
}

/// Does `visit` name all fields except so many bytes?
template <class Kind>
::testing::AssertionResult forgets(int num_bytes) {
  const int found = num_bytes_forgotten<Kind>();
  if (!kPaddingIsKnown || found == num_bytes) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "visit forgets " << found << " bytes";
}

}  // namespace swiftlet
