// SPDX-License-Identifier: BSD-3-Clause
#include "sim/report/html.hpp"

#include <fmt/core.h>

#include <cmath>

#include "embedded/sim_report.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim::html {
std::string number(double value) {
  if (!std::isfinite(value)) return "–";
  // From 1e4 on, four digits need an exponent; below 1e7, all digits are shorter.
  const double magnitude = std::abs(value);
  return magnitude >= 1e4 && magnitude < 1e7 ? fmt::format("{:.0f}", value) : fmt::format("{:.4g}", value);
}

std::string interval(double low, double high) {
  return std::isfinite(low) && std::isfinite(high) ? "[" + number(low) + ", " + number(high) + "]" : "–";
}

Table::Table(std::vector<std::string> head, std::vector<std::size_t> columns_of_words) : head_(std::move(head)) {
  is_words_.resize(head_.size(), false);
  for (const std::size_t column : columns_of_words) is_words_.at(column) = true;
}

std::string Table::cell(const char* tag, std::size_t column, const std::string& content) const {
  const bool words = column < is_words_.size() && is_words_[column];
  return std::string("<") + tag + (words ? " class=\"w\">" : ">") + content + "</" + tag + ">";
}

std::string Table::str() const {
  std::string text = "<div class=\"wide\"><table><thead><tr>";
  for (std::size_t i = 0; i < head_.size(); ++i) text += cell("th", i, head_[i]);
  text += "</tr></thead><tbody>\n";
  for (const auto& row : rows_) {
    text += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) text += cell("td", i, row[i]);
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

std::string code(const std::string& text) { return "<code>" + escape_markup(text) + "</code>"; }

std::string section(const std::string& title, const std::string& body) {
  return "<h2>" + escape_markup(title) + "</h2>\n" + body;
}

std::string folded(const std::string& title, const std::string& body) {
  return "<details><summary>" + escape_markup(title) + "</summary>\n" + body + "</details>\n";
}

std::string replay_frame(const std::string& address) {
  const std::string escaped = escape_markup(address);
  return "<p><a href=\"" + escaped + "\">Open the replay as a page of its own</a></p>\n<iframe src=\"" + escaped +
         "\" loading=\"lazy\" sandbox=\"allow-scripts allow-downloads\" title=\"replay\"></iframe>\n";
}

std::string page(const std::string& title, const std::string& body) {
  return fmt::format(fmt::runtime(embedded::page_html), fmt::arg("title", escape_markup(title)),
                     fmt::arg("style", embedded::page_css), fmt::arg("body", body));
}

}  // namespace swiftlet::sim::html
