// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/core/base/time.hpp"

namespace swiftlet::sim {

/// Words joined by commas: "a, b, c".
std::string listed(const std::vector<std::string>& words);

/// One line of values with a separator, as in a CSV file. A floating-point number is written with the fewest digits
/// that parse to the same bits.
class TextRow {
 public:
  explicit TextRow(char separator) : separator_(separator) {}

  void clear() { text_.clear(); }
  TextRow& add(double value);
  TextRow& add(std::integral auto value) { return add_integer(static_cast<std::int64_t>(value)); }
  TextRow& add(std::string_view word);
  template <class Derived>
  TextRow& add(const Eigen::DenseBase<Derived>& values) {
    for (Eigen::Index i = 0; i < values.size(); ++i) add(static_cast<double>(values.derived()(i)));
    return *this;
  }
  /// Adds a time in seconds with nine decimals, so that no nanosecond is lost.
  TextRow& add_seconds(TimeNs t);
  /// The line with its line break; valid until the next clear().
  std::string_view line();

 private:
  TextRow& add_integer(std::int64_t value);
  void separate();

  char separator_;
  std::string text_;
};

}  // namespace swiftlet::sim
