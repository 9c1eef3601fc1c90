// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/io/text_row.hpp"

#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

TextRow& TextRow::add(double value) {
  separate();
  append_number(text_, value);
  return *this;
}

TextRow& TextRow::add_integer(std::int64_t value) {
  separate();
  append_number(text_, value);
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
  append_number(text_, magnitude / kNsPerSecond);
  const std::string digits = shortest(magnitude % kNsPerSecond);
  text_.append(".").append(9 - digits.size(), '0').append(digits);
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
