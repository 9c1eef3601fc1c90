// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

/// Numbers as they lie in files that others wrote.
namespace swiftlet::sim {

/// A number of a binary file.
/// @param kind  i: signed, u: unsigned, f: floating
/// @param size  its bytes: 1, 2, 4, 8
/// @param swap  the file has the other order of bytes than this machine
double decode(const char* bytes, char kind, int size, bool swap);

/// The number that the whole word is; NaN where it is none or beyond the range of double.
double number_or_nan(std::string_view word);

/// Takes words off a text file, one number after the other.
class Words {
 public:
  Words(std::string_view content, std::size_t begin)
      : content_(content.data()), next_(content.data() + begin), end_(content.data() + content.size()) {}

  /// The next word as a number: nothing at the end or where it is none, NaN beyond the range of double.
  std::optional<double> number();
  /// Bytes that are left.
  std::size_t left() const { return static_cast<std::size_t>(end_ - next_); }
  /// Line of the latest word, from 1. It counts them all.
  std::size_t line() const;

 private:
  const char* content_;
  const char* next_;
  const char* end_;
};

}  // namespace swiftlet::sim
