// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#ifndef XXH_INLINE_ALL
#define XXH_INLINE_ALL
#endif
#include <xxhash.h>

#include <cstdint>
#include <cstring>

#include "swiftlet/core/base/field_bytes.hpp"

namespace swiftlet::sim {

/// Visitor that hashes every field of a data type. Data that fits into the buffer (all except scans) is hashed in one
/// call, which gives the same value as hashing in pieces at half the cost.
class Hasher : public FieldBytes<Hasher> {
 public:
  std::uint64_t digest() {
    if (!streaming_) return XXH3_64bits(buffer_, size_);
    flush();
    return XXH3_64bits_digest(&state_);
  }

 private:
  friend FieldBytes<Hasher>;
  /// [bytes] Size of the buffer. All data except scans fits.
  static constexpr std::size_t kCapacity = 2048;

  void bytes(const void* data, std::size_t size) {
    if (size > kCapacity - size_) {
      flush();
      if (size > kCapacity) {
        XXH3_64bits_update(&state_, data, size);
        return;
      }
    }
    if (size > 0) std::memcpy(buffer_ + size_, data, size);
    size_ += size;
  }
  void flush() {
    if (!streaming_) XXH3_64bits_reset(&state_);
    streaming_ = true;
    XXH3_64bits_update(&state_, buffer_, size_);
    size_ = 0;
  }

  std::size_t size_ = 0;
  bool streaming_ = false;
  unsigned char buffer_[kCapacity];
  XXH3_state_t state_;
};

}  // namespace swiftlet::sim
