// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

/// Decoding of numbers in files of other programs.
namespace swiftlet::sim {

/// Decodes a number of a binary file.
/// @param kind  i: signed, u: unsigned, f: floating
/// @param size  1, 2, 4 or 8 bytes
/// @param swap  the file's byte order differs from this machine's
double decode(const char* bytes, char kind, int size, bool swap);

/// The number represented by the whole word; NaN for an invalid one or one beyond the range of double.
double number_or_nan(std::string_view word);

/// Sequential reading of numbers in a text file.
class Words {
 public:
  Words(std::string_view content, std::size_t begin)
      : content_(content.data()), next_(content.data() + begin), end_(content.data() + content.size()) {}

  /// The next word as a number: empty at the end or for an invalid one, NaN beyond the range of double.
  std::optional<double> number();
  /// Number of remaining bytes.
  std::size_t left() const { return static_cast<std::size_t>(end_ - next_); }
  /// Line of the latest word, from 1, counted on each call.
  std::size_t line() const;

 private:
  const char* content_;
  const char* next_;
  const char* end_;
};

}  // namespace swiftlet::sim
