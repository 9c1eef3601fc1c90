// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

/// Checks that all numbers of a value are finite: neither infinite nor NaN. Applied to every value passed between
/// stages.
namespace swiftlet {

inline bool is_finite(double value) { return value * 0.0 == 0.0; }

/// Multiplies each coefficient by zero, which gives NaN if it is infinite or NaN; then the sum is NaN too.
template <class Derived>
bool is_finite(const Eigen::MatrixBase<Derived>& matrix) {
  return (matrix * 0.0).sum() == 0.0;
}

inline bool is_finite(const Eigen::Quaterniond& q) { return is_finite(q.coeffs()); }
inline bool is_finite(const Pose& pose) { return is_finite(pose.affine()); }

/// Counts the values with all exponent bits set: infinity and NaN. Without an early exit, compilers vectorize the loop.
inline bool is_finite(std::span<const float> values) {
  constexpr std::uint32_t kExponentBits = 0x7f800000U;
  std::uint32_t count = 0;
  for (const float value : values) count += (std::bit_cast<std::uint32_t>(value) & kExponentBits) == kExponentBits;
  return count == 0;
}

/// Visitor of a struct with a `visit` (swiftlet/core/base/fields.hpp) that checks all its numbers.
class FiniteNumbers {
 public:
  /// True if all visited numbers are finite.
  bool all() const { return all_; }

  void time(const char*, TimeNs, const char*) {}
  void valid(const char*, bool, const char*) {}
  void vehicle(const char*, VehicleId, const char*) {}
  void choice(const char*, const auto&, std::span<const char* const>, const char*) {}
  void field(const char*, const auto& value, const char*) {
    if constexpr (requires { is_finite(value); }) all_ = all_ && is_finite(value);
  }
  void covariance(const char*, const auto& matrix, const char*) { all_ = all_ && is_finite(matrix); }
  void array(const char*, const auto& values, const char*) {
    for (const auto& value : values) all_ = all_ && is_finite(value);
  }
  template <class T>
  void list(const char*, const std::vector<T>& values, const char*) {
    for (const T& value : values) T::visit(value, *this);
  }

 private:
  bool all_ = true;
};

template <class Kind>
requires requires(const Kind& kind, FiniteNumbers& numbers) { Kind::visit(kind, numbers); }
bool is_finite(const Kind& kind) {
  FiniteNumbers numbers;
  Kind::visit(kind, numbers);
  return numbers.all();
}

}  // namespace swiftlet
