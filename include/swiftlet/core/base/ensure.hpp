// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <concepts>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

/// Contracts that stay enabled in optimized builds. A failure means an error of the program, not of its input.
///
///   ENSURE(index < size, index, size);
///
/// throws a ContractViolation with the text "core/map/x.cpp:12: ENSURE(index < size): index = 7, size = 5". The values
/// are evaluated on failure only; a contract that holds costs only its condition.
namespace swiftlet {

/// what() is one line. Programs report it as an internal error, with exit status 1.
class ContractViolation : public std::logic_error {
  using std::logic_error::logic_error;
};

namespace contract {

struct Place {
  const char* expression;
  const char* names;  // names of the values, separated by commas
  const char* file;
  int line;
};

void append(std::string& text, double value);
void append(std::string& text, std::int64_t value);
void append(std::string& text, std::uint64_t value);
void append(std::string& text, std::string_view value);

/// A number, a word, an enumerator by its number, or an Eigen vector or matrix by its coefficients.
template <class T>
void append_value(std::string& text, const T& value) {
  if constexpr (std::convertible_to<const T&, std::string_view>) {
    append(text, std::string_view(value));
  } else if constexpr (std::same_as<T, bool>) {
    text += value ? "true" : "false";
  } else if constexpr (std::floating_point<T>) {
    append(text, static_cast<double>(value));
  } else if constexpr (std::signed_integral<T> || std::is_enum_v<T>) {
    append(text, static_cast<std::int64_t>(value));
  } else if constexpr (std::unsigned_integral<T>) {
    append(text, static_cast<std::uint64_t>(value));
  } else {
    text += '(';
    for (std::int64_t i = 0; i < value.size(); ++i) {
      if (i > 0) text += ", ";
      append_value(text, value.reshaped()(i));
    }
    text += ')';
  }
}

/// Appends "name = " with the next name of the list and removes it from the list.
void append_name(std::string& text, std::string_view& names);
[[noreturn]] void fail(const Place& place, const std::string& values);

template <class... Values>
[[noreturn, gnu::cold, gnu::noinline]] void fail_with(const Place& place, const Values&... values) {
  std::string text;
  [[maybe_unused]] std::string_view names = place.names;
  ((append_name(text, names), append_value(text, values)), ...);
  fail(place, text);
}

}  // namespace contract
}  // namespace swiftlet

#define ENSURE(condition, ...)                       \
  (__builtin_expect(static_cast<bool>(condition), 1) \
       ? static_cast<void>(0)                        \
       : ::swiftlet::contract::fail_with({#condition, #__VA_ARGS__, __FILE__, __LINE__} __VA_OPT__(, ) __VA_ARGS__))
