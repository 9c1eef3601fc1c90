// SPDX-License-Identifier: BSD-3-Clause
#include "published.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <stdexcept>
#include <vector>

#include "embedded/tools_experiments.hpp"

namespace swiftlet::tools {
namespace {

// The cells of one line (RFC 4180, without line breaks in cells).
std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

double number_in(std::string_view text) {
  double value = std::numeric_limits<double>::quiet_NaN();
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

PublishedFigure figure_of(std::string_view line) {
  std::vector<std::string> cells = cells_of(line);
  if (cells.size() != 4) throw std::logic_error("published.csv: expected four cells, found: " + std::string(line));
  constexpr std::string_view kPlusMinus = " ± ";
  const std::size_t deviation = cells[2].find(kPlusMinus);
  PublishedFigure figure{cells[0], cells[1], cells[2], cells[3], number_in(cells[2]), number_in("")};
  if (deviation != std::string::npos) {
    figure.deviation = number_in(std::string_view(cells[2]).substr(deviation + kPlusMinus.size()));
  }
  return figure;
}

std::vector<PublishedFigure> read_table() {
  std::vector<PublishedFigure> figures;
  std::string_view rest = embedded::published_csv;
  for (rest.remove_prefix(rest.find('\n') + 1); !rest.empty(); rest.remove_prefix(rest.find('\n') + 1)) {
    figures.push_back(figure_of(rest.substr(0, rest.find('\n'))));
  }
  return figures;
}

bool is_named(const PublishedFigure& figure, std::string_view what) {
  return figure.what.starts_with('*') ? what.ends_with(figure.what.substr(1)) : what == figure.what;
}

}  // namespace

std::span<const PublishedFigure> published_figures() {
  static const std::vector<PublishedFigure> figures = read_table();
  return figures;
}

const PublishedFigure* find_published(std::string_view experiment, std::string_view what) {
  const auto figures = published_figures();
  const auto found = std::find_if(figures.begin(), figures.end(), [&](const PublishedFigure& figure) {
    return figure.experiment == experiment && is_named(figure, what);
  });
  return found == figures.end() ? nullptr : &*found;
}

}  // namespace swiftlet::tools
