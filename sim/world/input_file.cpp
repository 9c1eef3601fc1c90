// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/input_file.hpp"

#include <algorithm>

#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBlanks = " \t\r\v\f";

}  // namespace

void reject_file(const fs::path& file, const std::string& reason) { throw InputError(file.string() + ": " + reason); }

void reject_file(const fs::path& file, std::size_t line, const std::string& reason) {
  throw InputError(file.string() + ":" + std::to_string(line) + ": " + reason);
}

std::string extension_of(const fs::path& file) {
  const std::string extension = file.extension().string();
  return extension.empty() ? extension : lower_case(std::string_view(extension).substr(1));
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

int axis_named(std::string_view column) {
  constexpr std::string_view kAxes = "xyzXYZ";
  const std::size_t at = column.size() == 1 ? kAxes.find(column[0]) : std::string_view::npos;
  return at == std::string_view::npos ? -1 : static_cast<int>(at % 3);
}

std::string_view without_mark(std::string_view content) {
  return content.substr(content.starts_with("\xEF\xBB\xBF") ? 3 : 0);
}

bool TextLines::next() {
  if (end_ >= text_.size()) return false;
  const std::size_t newline = std::min(text_.find('\n', end_), text_.size());
  line_ = text_.substr(end_, newline - end_);
  if (line_.ends_with('\r')) line_.remove_suffix(1);
  end_ = std::min(newline + 1, text_.size());
  ++number_;
  return true;
}

void split(std::string_view line, std::vector<std::string_view>& words) {
  words.clear();
  for (std::size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
}

std::string rest_of(std::string_view line) {
  const std::size_t word = std::min(line.find_first_not_of(kBlanks), line.size());
  const std::size_t blank = std::min(line.find_first_of(kBlanks, word), line.size());
  const std::size_t begin = line.find_first_not_of(kBlanks, blank);
  if (begin == std::string_view::npos) return {};
  return std::string(line.substr(begin, line.find_last_not_of(kBlanks) + 1 - begin));
}

}  // namespace swiftlet::sim
