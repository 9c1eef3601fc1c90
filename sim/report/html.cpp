// SPDX-License-Identifier: BSD-3-Clause
#include "sim/report/html.hpp"

#include <fmt/core.h>

#include <cmath>

#include "sim/io/text.hpp"

namespace swiftlet::sim::html {
namespace {

constexpr const char* kStyle =
    "body{font:15px/1.5 system-ui,sans-serif;color:#222;max-width:1180px;margin:2em auto;padding:0 1em}"
    "h1{font-size:1.6em;margin-bottom:.2em}h2{font-size:1.2em;margin-top:2em;border-bottom:1px solid #ddd}"
    "table{border-collapse:collapse;margin:.8em 0;font-variant-numeric:tabular-nums}"
    "th,td{padding:.2em .7em;text-align:right;white-space:nowrap;border-bottom:1px solid #eee}"
    "th{background:#f6f6f6;font-weight:600}th.w,td.w{text-align:left;white-space:normal}"
    "code{font-size:.86em;background:#f4f4f4;padding:.1em .3em;overflow-wrap:anywhere}.note{color:#666}"
    "svg,img{max-width:100%;height:auto}"
    "figure{display:inline-block;margin:.5em 1em .5em 0}figcaption{color:#666;font-size:.9em}"
    "details{margin:.6em 0}summary{cursor:pointer;color:#0057a0}.wide{overflow-x:auto}";

}  // namespace

std::string number(double value) {
  if (!std::isfinite(value)) return "–";
  // No powers of ten where plain digits are as short.
  const double size = std::abs(value);
  return size >= 1e4 && size < 1e7 ? fmt::format("{:.0f}", value) : fmt::format("{:.4g}", value);
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

std::string page(const std::string& title, const std::string& body) {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" + escape_markup(title) +
         "</title><meta name=\"viewport\" content=\"width=device-width\"><style>" + kStyle +
         "</style></head>\n<body>\n" + body + "</body></html>\n";
}

}  // namespace swiftlet::sim::html
