// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/base/ensure.hpp"

#include <array>
#include <charconv>

namespace swiftlet::contract {
namespace {

template <class Number>
void append_number(std::string& text, Number value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text.append(digits.data(), end);
}

/// Path of a file in messages: a header's as in #include, after the folder of links that cmake/Rooms.cmake makes; a
/// source's relative to the root of the sources, which is found from the path of this file.
std::string_view from_root(std::string_view file) {
  constexpr std::string_view kThisFile = __FILE__;
  constexpr std::string_view kThisFileFromRoot = "core/base/ensure.cpp";
  static_assert(kThisFile.ends_with(kThisFileFromRoot));
  for (const std::string_view link_folder : {"/public/", "/private/"}) {
    if (const auto at = file.rfind(link_folder); at != file.npos) return file.substr(at + link_folder.size());
  }
  const std::string_view root = kThisFile.substr(0, kThisFile.size() - kThisFileFromRoot.size());
  return file.starts_with(root) ? file.substr(root.size()) : file;
}

}  // namespace

void append(std::string& text, double value) { append_number(text, value); }
void append(std::string& text, std::int64_t value) { append_number(text, value); }
void append(std::string& text, std::uint64_t value) { append_number(text, value); }
void append(std::string& text, std::string_view value) { text.append("\"").append(value).append("\""); }

void append_name(std::string& text, std::string_view& names) {
  // A comma within brackets does not end the name, such as in `at(x, y)`.
  std::size_t end = 0;
  for (int depth = 0; end < names.size() && (depth > 0 || names[end] != ','); ++end) {
    if (names[end] == '(' || names[end] == '[' || names[end] == '{') ++depth;
    if (names[end] == ')' || names[end] == ']' || names[end] == '}') --depth;
  }
  if (!text.empty()) text += ", ";
  text.append(names.substr(0, end)).append(" = ");
  names.remove_prefix(end);
  while (!names.empty() && (names.front() == ',' || names.front() == ' ')) names.remove_prefix(1);
}

void fail(const Place& place, const std::string& values) {
  std::string text(from_root(place.file));
  text.append(":").append(std::to_string(place.line)).append(": ENSURE(").append(place.expression).append(")");
  if (!values.empty()) text.append(": ").append(values);
  throw ContractViolation(text);
}

}  // namespace swiftlet::contract
