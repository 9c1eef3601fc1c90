// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// Reading of files of other programs, line by line. Faults throw one-line errors with file and reason.
namespace swiftlet::sim {

/// Throws InputError: "<file>: <reason>".
[[noreturn]] void reject_file(const std::filesystem::path& file, const std::string& reason);
/// Throws InputError: "<file>:<line>: <reason>".
[[noreturn]] void reject_file(const std::filesystem::path& file, std::size_t line, const std::string& reason);

/// The extension in lower case without its dot.
std::string extension_of(const std::filesystem::path& file);

std::string lower_case(std::string_view text);

/// Axis 0, 1, 2 of a column named x, y, z or X, Y, Z; -1 for any other.
int axis_named(std::string_view column);

/// The content without a UTF-8 byte order mark.
std::string_view without_mark(std::string_view content);

/// The lines of a text, with line breaks LF or CR LF.
class TextLines {
 public:
  explicit TextLines(std::string_view text) : text_(text) {}
  /// Advances to the next line; false at the end of the text.
  bool next();
  std::string_view line() const { return line_; }  ///< without its line break
  std::size_t number() const { return number_; }   ///< from 1
  std::size_t end() const { return end_; }         ///< offset of the following line

 private:
  std::string_view text_, line_;
  std::size_t number_ = 0, end_ = 0;
};

/// Replaces `words` by the words of the line.
void split(std::string_view line, std::vector<std::string_view>& words);

/// The line after its first word, trimmed; a name may contain blanks.
std::string rest_of(std::string_view line);

}  // namespace swiftlet::sim
