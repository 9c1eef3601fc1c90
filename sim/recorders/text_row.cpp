// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/text_row.hpp"

#include <charconv>

namespace swiftlet::sim {

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

TextRow& TextRow::add(double value) {
  separate();
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text_.append(digits, end);
  return *this;
}

TextRow& TextRow::add_integer(std::int64_t value) {
  separate();
  char digits[24];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text_.append(digits, end);
  return *this;
}

TextRow& TextRow::add(std::string_view word) {
  separate();
  text_.append(word);
  return *this;
}

TextRow& TextRow::add_seconds(TimeNs t) {
  separate();
  if (t < 0) text_.push_back('-');
  const std::uint64_t magnitude = t < 0 ? 0 - static_cast<std::uint64_t>(t) : static_cast<std::uint64_t>(t);
  char digits[24];
  auto end = std::to_chars(digits, digits + sizeof digits, magnitude / kNsPerSecond).ptr;
  text_.append(digits, end);
  end = std::to_chars(digits, digits + sizeof digits, magnitude % kNsPerSecond).ptr;
  text_.push_back('.');
  text_.append(9 - static_cast<std::size_t>(end - digits), '0');
  text_.append(digits, end);
  return *this;
}

std::string_view TextRow::line() {
  text_.push_back('\n');
  return text_;
}

void TextRow::separate() {
  if (!text_.empty()) text_.push_back(separator_);
}

}  // namespace swiftlet::sim
