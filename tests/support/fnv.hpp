// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace swiftlet::test {

/// FNV-1a of 64 bits.
class Fnv1a {
 public:
  /// Hashes bytes one by one.
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) mix(bytes[i]);
  }
  /// One step with a whole word instead of a byte.
  void mix(std::uint64_t word) { hash_ = (hash_ ^ word) * 0x100000001B3ULL; }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xCBF29CE484222325ULL;
};

}  // namespace swiftlet::test
