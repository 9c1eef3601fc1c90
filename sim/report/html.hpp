// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

/// The little HTML that reports are made of: one file, no scripts, no network.
namespace swiftlet::sim::html {

/// Four significant digits, or all before the point; a dash for what was not measured.
std::string number(double value);

/// "[low, high]".
std::string interval(double low, double high);

/// Rows under a head. Columns of words are aligned left and may break; the others are numbers.
class Table {
 public:
  explicit Table(std::vector<std::string> head, std::vector<std::size_t> columns_of_words = {0});
  /// Cells are HTML already.
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  bool empty() const { return rows_.empty(); }
  std::string str() const;

 private:
  std::string cell(const char* tag, std::size_t column, const std::string& content) const;

  std::vector<std::string> head_;
  std::vector<bool> is_words_;  // by column
  std::vector<std::vector<std::string>> rows_;
};

std::string code(const std::string& text);
std::string section(const std::string& title, const std::string& body);
/// Shown on a click.
std::string folded(const std::string& title, const std::string& body);
/// A replay beside the page, loaded when it is shown, in a sandbox: it may be of another origin than the report.
std::string replay_frame(const std::string& address);
/// A whole page.
std::string page(const std::string& title, const std::string& body);

}  // namespace swiftlet::sim::html
