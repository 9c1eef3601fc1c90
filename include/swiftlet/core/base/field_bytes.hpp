// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Visitor that passes every field of a kind of data (swiftlet/core/base/fields.hpp) as bytes to `Derived::bytes(data,
/// size)`; texts and lists with their length. Structs are visited field by field, because padding has no defined
/// content.
template <class Derived>
class FieldBytes {
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
    put(matrix.data(), matrix.size() * sizeof(double));
  }
  template <std::size_t N>
  void array(const char*, const std::array<double, N>& values, const char*) {
    put(values.data(), sizeof values);
  }
  template <class T>
  void list(const char*, const std::vector<T>& values, const char*) {
    add(values.size());
    for (const T& value : values) T::visit(value, static_cast<Derived&>(*this));
  }

 private:
  void put(const void* data, std::size_t size) { static_cast<Derived*>(this)->bytes(data, size); }
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void add(Number value) { put(&value, sizeof value); }
  void add(bool value) { add(std::int32_t{value}); }
  void add(const Vector3& value) { put(value.data(), 3 * sizeof(double)); }
  void add(const Eigen::Quaterniond& q) { put(q.coeffs().data(), 4 * sizeof(double)); }
  void add(const Pose& pose) {
    const Matrix3 rotation = pose.linear();
    put(rotation.data(), 9 * sizeof(double));
    add(Vector3(pose.translation()));
  }
  void add(const std::string& text) {
    add(text.size());
    put(text.data(), text.size());
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(values.size());
    put(values.data(), values.size() * sizeof(T));
  }
};

}  // namespace swiftlet
