// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#ifndef XXH_INLINE_ALL
#define XXH_INLINE_ALL
#endif
#include <xxhash.h>

#include <array>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "swiftlet/core/frames.hpp"

namespace swiftlet::sim {

/// The visitor that hashes a kind of data: every field that its `visit` names; texts and lists with their length. It is
/// fed values, never whole structs, because padding bytes have no defined content. What fits into the buffer (anything
/// but scans) is hashed at once. That gives the same value as bit by bit and costs half as much.
class Hasher {
 public:
  void time(const char*, TimeNs t, const char*) { add(t); }
  template <class T>
  void field(const char*, const T& value, const char*) {
    add(value);
  }
  void valid(const char*, bool value, const char*) { add(value); }
  void vehicle(const char*, VehicleId id, const char*) { add(id); }
  template <class Enum>
  void choice(const char*, Enum value, std::span<const char* const>, const char*) {
    add(static_cast<std::int32_t>(value));
  }
  template <class Matrix>
  void covariance(const char*, const Matrix& matrix, const char*) {
    bytes(matrix.data(), matrix.size() * sizeof(double));
  }
  template <std::size_t N>
  void array(const char*, const std::array<double, N>& values, const char*) {
    bytes(values.data(), sizeof values);
  }
  template <class T>
  void list(const char*, const std::vector<T>& values, const char*) {
    add(values.size());
    for (const T& value : values) T::visit(value, *this);
  }

  std::uint64_t digest() {
    if (!streaming_) return XXH3_64bits(buffer_, size_);
    flush();
    return XXH3_64bits_digest(&state_);
  }

 private:
  static constexpr std::size_t kCapacity = 2048;

  template <class Number>
  requires std::is_arithmetic_v<Number>
  void add(Number value) { bytes(&value, sizeof value); }
  void add(bool value) { add(std::int32_t{value}); }
  void add(const Vector3& value) { bytes(value.data(), 3 * sizeof(double)); }
  void add(const Eigen::Quaterniond& q) { bytes(q.coeffs().data(), 4 * sizeof(double)); }
  void add(const Pose& pose) {
    const Matrix3 rotation = pose.linear();
    bytes(rotation.data(), 9 * sizeof(double));
    add(Vector3(pose.translation()));
  }
  void add(const std::string& text) {
    add(text.size());
    bytes(text.data(), text.size());
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(values.size());
    bytes(values.data(), values.size() * sizeof(T));
  }

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
