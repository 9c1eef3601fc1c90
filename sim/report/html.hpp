// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

/// HTML elements of reports: one file, no scripts, no network.
namespace swiftlet::sim::html {

/// Four significant digits, or all before the decimal point; a dash for NaN.
std::string number(double value);

/// "[low, high]".
std::string interval(double low, double high);

/// A table with header. Columns of words are left-aligned and may wrap; the others contain numbers.
class Table {
 public:
  explicit Table(std::vector<std::string> head, std::vector<std::size_t> columns_of_words = {0});
  /// Adds a row; cells must be HTML.
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  bool empty() const { return rows_.empty(); }
  std::string str() const;

 private:
  std::string cell(const char* tag, std::size_t column, const std::string& content) const;

  std::vector<std::string> head_;
  std::vector<bool> is_words_;  // indexed by column
  std::vector<std::vector<std::string>> rows_;
};

std::string code(const std::string& text);
std::string section(const std::string& title, const std::string& body);
/// A collapsed section.
std::string folded(const std::string& title, const std::string& body);
/// An embedded replay, loaded when opened, in a sandbox, since its origin may differ from the report's.
std::string replay_frame(const std::string& address);
/// A whole page.
std::string page(const std::string& title, const std::string& body);

}  // namespace swiftlet::sim::html
