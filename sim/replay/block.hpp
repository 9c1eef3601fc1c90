// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace swiftlet::sim {

/// Values of a column are stored as integer multiples of `step`.
struct ReplayColumn {
  std::string name;
  double step = 1.0;
};

/// A table of numbers. NaN is stored as missing; values too large for the step are clamped.
class ReplayTable {
 public:
  /// Quantized value that marks a missing number.
  static constexpr std::int32_t kMissing = -(1 << 29);

  /// @param about  a JSON object that describes the table
  ReplayTable(std::string about, std::vector<ReplayColumn> columns);

  void add(std::span<const double> row);
  void add(std::initializer_list<double> row) { add(std::span(row.begin(), row.size())); }
  std::size_t rows() const { return columns_.empty() ? 0 : values_.front().size(); }
  void clear();

  const std::string& about() const { return about_; }
  void set_about(std::string about) { about_ = std::move(about); }
  const std::vector<ReplayColumn>& columns() const { return columns_; }
  const std::vector<std::int32_t>& values(std::size_t column) const { return values_[column]; }

 private:
  std::string about_;
  std::vector<ReplayColumn> columns_;
  std::vector<std::vector<std::int32_t>> values_;  // indexed by column
};

/// Unit of decoding by the page: a length (uint32), that many bytes of JSON, and the columns of all tables. A column
/// contains the differences of its values, zigzag-coded, in base-128 digits, the lowest first.
class ReplayBlock {
 public:
  /// @param about  a JSON object; its "kind" determines how the page uses the block
  explicit ReplayBlock(std::string about) : about_(std::move(about)) {}

  void add(const ReplayTable& table);
  bool empty() const { return heads_.empty(); }
  std::string bytes() const;

 private:
  std::string about_;
  std::string heads_;  // JSON of the tables, separated by commas
  std::string body_;
};

/// gzip format without name and time: equal input gives equal bytes.
std::string gzip(std::string_view bytes);

}  // namespace swiftlet::sim
