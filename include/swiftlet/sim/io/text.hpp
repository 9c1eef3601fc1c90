// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

/// Numbers and words in text files, equal on every machine and in every locale. Numbers with a fixed number of digits
/// are formatted with fmt.
namespace swiftlet::sim {

/// Writes the fewest digits that parse to the same number.
template <class Number>
requires std::is_arithmetic_v<Number>
void append_number(std::string& text, Number value) {
  char digits[40];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

/// Returns the fewest digits that parse to the same number.
template <class Number>
std::string shortest(Number value) {
  std::string text;
  append_number(text, value);
  return text;
}

/// The number that the whole text represents; empty otherwise.
template <class Number>
std::optional<Number> number_in(std::string_view text) {
  Number value{};
  const char* end = text.data() + text.size();
  const auto [at, problem] = std::from_chars(text.data(), end, value);
  if (problem != std::errc() || at != end) return std::nullopt;
  return value;
}

/// 16 hexadecimal digits, the text form of 64-bit hashes.
std::string hex64(std::uint64_t value);

/// A cell of a CSV table, quoted where necessary (RFC 4180).
std::string csv_cell(std::string_view text);
/// A number; empty for NaN.
std::string csv_cell(double value);

/// Escapes text for content and attributes of HTML and SVG.
std::string escape_markup(std::string_view text);

}  // namespace swiftlet::sim
