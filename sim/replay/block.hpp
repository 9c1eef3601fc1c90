// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace swiftlet::sim {

/// Values of a column are told as whole multiples of `step`.
struct ReplayColumn {
  std::string name;
  double step = 1.0;
};

/// A table of numbers. What is not a number is missing; what is too large for its step becomes the largest there is.
class ReplayTable {
 public:
  static constexpr std::int32_t kMissing = -(1 << 29);

  /// @param about  a JSON object that tells what the table is
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
  std::vector<std::vector<std::int32_t>> values_;  // by column
};

/// What the page decodes at a time: a length (uint32), that many bytes of JSON, and the columns of all tables. A column
/// is the differences of its values, zigzag-coded, in base-128 digits, the lowest first.
class ReplayBlock {
 public:
  /// @param about  a JSON object; its "kind" tells the page what to do with the block
  explicit ReplayBlock(std::string about) : about_(std::move(about)) {}

  void add(const ReplayTable& table);
  bool empty() const { return heads_.empty(); }
  std::string bytes() const;

 private:
  std::string about_;
  std::string heads_;  // JSON of the tables, separated by commas
  std::string body_;
};

/// As gzip writes it, without name and time: the same bytes give the same bytes.
std::string gzip(std::string_view bytes);

}  // namespace swiftlet::sim
