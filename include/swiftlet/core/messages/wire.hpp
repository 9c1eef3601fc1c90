// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "swiftlet/core/base/message.hpp"
#include "swiftlet/core/base/rounding.hpp"

/// Encoding of a message's content: field after field in the order of its `visit`, little-endian, without padding. A
/// time has 8 bytes, a vehicle and an `int` 4, a flag and a choice 1, a pose 56 (position, quaternion). Texts and lists
/// are preceded by their length in 2 bytes. Only the upper triangle of a covariance is encoded.
namespace swiftlet {

/// Appends fields to a byte buffer.
class WireWriter {
 public:
  static constexpr bool kReads = false;
  explicit WireWriter(std::vector<std::byte>& bytes) : bytes_(bytes) {}

  void bits(std::uint64_t value, int num_bytes) {
    for (int i = 0; i < num_bytes; ++i) bytes_.push_back(static_cast<std::byte>(value >> (8 * i)));
  }

 private:
  std::vector<std::byte>& bytes_;
};

/// Reads fields from a byte buffer. Missing bytes read as zero and set `short_of_bytes`.
class WireReader {
 public:
  static constexpr bool kReads = true;
  explicit WireReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  std::uint64_t bits(int num_bytes) {
    if (rest_.size() < static_cast<std::size_t>(num_bytes)) {
      short_ = true;
      rest_ = {};
      return 0;
    }
    std::uint64_t value = 0;
    for (int i = 0; i < num_bytes; ++i) value |= std::to_integer<std::uint64_t>(rest_[i]) << (8 * i);
    rest_ = rest_.subspan(num_bytes);
    return value;
  }
  bool short_of_bytes() const { return short_; }
  std::size_t num_left() const { return rest_.size(); }

 private:
  std::span<const std::byte> rest_;
  bool short_ = false;
};

/// Visitor over a writer or a reader, so that one set of rules defines both directions.
template <class Stream>
class Wire {
 public:
  explicit Wire(Stream stream) : stream_(stream) {}
  const Stream& stream() const { return stream_; }
  bool has_bad_value() const { return bad_; }

  void time(const char*, auto& t, const char*) { number(t); }
  void valid(const char*, auto& value, const char*) { number(value); }
  void vehicle(const char*, auto& id, const char*) { number(id); }

  template <class T>
  void field(const char*, T& value, const char*) {
    exchange(value);
  }
  template <class Enum>
  void choice(const char*, Enum& value, std::span<const char* const> words, const char*) {
    auto index = static_cast<std::uint8_t>(value);
    number(index);
    bad_ = bad_ || index >= words.size();
    if constexpr (Stream::kReads) value = static_cast<Enum>(bad_ ? 0 : index);
  }
  template <class Matrix>
  void covariance(const char*, Matrix& matrix, const char*) {
    for (int i = 0; i < matrix.rows(); ++i) {
      for (int j = i; j < matrix.cols(); ++j) {
        number(matrix(i, j));
        if constexpr (Stream::kReads) matrix(j, i) = matrix(i, j);
      }
    }
  }
  template <class Array>
  void array(const char*, Array& values, const char*) {
    for (auto& value : values) number(value);
  }
  template <class List>
  void list(const char*, List& values, const char*) {
    exchange_length(values, [this](auto& value) { std::remove_cvref_t<decltype(value)>::visit(value, *this); });
  }

 private:
  /// Numbers in their native size.
  template <class Number>
  requires std::is_arithmetic_v<std::remove_const_t<Number>>
  void number(Number& value) {
    using Plain = std::remove_const_t<Number>;
    if constexpr (Stream::kReads) {
      value = from_bits<Plain>(stream_.bits(sizeof(Plain)));
      if constexpr (std::is_floating_point_v<Plain>) bad_ = bad_ || !std::isfinite(value);
    } else {
      stream_.bits(to_bits(value), sizeof(Plain));
    }
  }

  template <class T>
  void exchange(T& value) {
    using Plain = std::remove_const_t<T>;
    if constexpr (std::is_arithmetic_v<Plain>) {
      number(value);
    } else if constexpr (std::is_same_v<Plain, Pose>) {
      exchange_pose(value);
    } else if constexpr (requires { value.coeffs(); }) {
      for (int i = 0; i < 4; ++i) number(value.coeffs()[i]);  // x, y, z, w
    } else if constexpr (requires { value.colwise(); }) {
      for (int i = 0; i < value.size(); ++i) number(value(i));
    } else {
      exchange_length(value, [this](auto& element) { this->number(element); });  // texts, lists of numbers
    }
  }

  void exchange_pose(const Pose& pose) {
    const Eigen::Quaterniond rotation(pose.linear());
    const Vector3 position = pose.translation();
    exchange(position);
    exchange(rotation);
  }
  void exchange_pose(Pose& pose) {
    Vector3 position;
    Eigen::Quaterniond rotation;
    exchange(position);
    exchange(rotation);
    bad_ = bad_ || !(std::abs(rotation.norm() - 1.0) < kRounding);
    pose = make_pose(position, rotation.normalized());
  }

  template <class List, class Each>
  void exchange_length(List& values, const Each& each) {
    auto length = static_cast<std::uint16_t>(values.size());
    bad_ = bad_ || length != values.size();
    number(length);
    if constexpr (Stream::kReads) {
      values.clear();
      for (int i = 0; i < length && !stream_.short_of_bytes(); ++i) {
        values.push_back(typename List::value_type{});
        each(values.back());
      }
    } else {
      for (int i = 0; i < length; ++i) each(values[i]);
    }
  }

  template <class Number>
  static std::uint64_t to_bits(Number value) {
    if constexpr (std::is_same_v<Number, double>) {
      return std::bit_cast<std::uint64_t>(value);
    } else if constexpr (std::is_same_v<Number, float>) {
      return std::bit_cast<std::uint32_t>(value);
    } else {
      return static_cast<std::uint64_t>(value);
    }
  }
  template <class Number>
  static Number from_bits(std::uint64_t bits) {
    if constexpr (std::is_same_v<Number, double>) {
      return std::bit_cast<double>(bits);
    } else if constexpr (std::is_same_v<Number, float>) {
      return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    } else {
      return static_cast<Number>(bits);
    }
  }

  Stream stream_;
  bool bad_ = false;
};

}  // namespace swiftlet
