// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstddef>
#include <cstring>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace swiftlet::sim {

static_assert(std::endian::native == std::endian::little,
              "the recorders write little-endian files as they stand in memory");

/// Lets a vector grow without initializing elements that the caller overwrites.
template <class T>
struct UnsetAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UnsetAllocator<U>;
  };
  template <class U>
  void construct(U* place) noexcept(std::is_nothrow_default_constructible_v<U>) {
    ::new (static_cast<void*>(place)) U;
  }
  template <class U, class... Args>
  void construct(U* place, Args&&... args) {
    ::new (static_cast<void*>(place)) U(std::forward<Args>(args)...);
  }
};

/// Bytes in the order of the calls; numbers are little-endian. Keeps its memory when cleared.
class ByteBuffer {
 public:
  void clear() { bytes_.clear(); }
  std::size_t size() const { return bytes_.size(); }
  bool empty() const { return bytes_.empty(); }
  std::span<const std::byte> bytes() const { return bytes_; }
  std::span<const std::byte> bytes_from(std::size_t offset) const { return bytes().subspan(offset); }

  template <class Number>
  requires std::is_arithmetic_v<Number>
  void put(Number value) { std::memcpy(extend(sizeof value), &value, sizeof value); }
  void put_bytes(std::span<const std::byte> bytes) {
    if (!bytes.empty()) std::memcpy(extend(bytes.size()), bytes.data(), bytes.size());
  }
  void put_text(std::string_view text) { put_bytes(std::as_bytes(std::span(text))); }
  /// Overwrites a number at an earlier offset.
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void put_at(std::size_t offset, Number value) { std::memcpy(bytes_.data() + offset, &value, sizeof value); }
  /// Appends `count` zero bytes for the caller to overwrite before the next put.
  std::byte* grow(std::size_t count) { return static_cast<std::byte*>(std::memset(extend(count), 0, count)); }
  /// As grow(), but uninitialized: the caller must overwrite every byte that remains.
  std::byte* extend(std::size_t count) {
    bytes_.resize(bytes_.size() + count);
    return bytes_.data() + bytes_.size() - count;
  }
  void shrink_to(std::size_t size) { bytes_.resize(size); }

 private:
  std::vector<std::byte, UnsetAllocator<std::byte>> bytes_;
};

}  // namespace swiftlet::sim
