// SPDX-License-Identifier: BSD-3-Clause
// The published figures in the pages equal those in published.csv.
#include "published.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "experiment.hpp"

namespace swiftlet::tools {
namespace {

std::vector<std::string> lines_of(const std::string& document) {
  std::ifstream stream(std::string(SWIFTLET_SOURCE_DIR) + "/docs/" + document);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  EXPECT_FALSE(lines.empty()) << document;
  return lines;
}

// The cells of a row of a table in Markdown; empty for any other line.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  if (!line.starts_with("| ")) return cells;
  for (std::size_t at = 2, end; (end = line.find(" |", at)) != std::string::npos; at = end + 3) {
    cells.push_back(line.substr(at, end - at));
    if (end + 3 > line.size()) break;
  }
  return cells;
}

TEST(Published, NumbersAndDeviationsAreReadFromTheText) {
  const PublishedFigure* length = find_published("rbl-forest", "L [m]");
  ASSERT_NE(length, nullptr);
  EXPECT_EQ(length->text, "91.99 ± 0.96");
  EXPECT_EQ(length->value, 91.99);
  EXPECT_EQ(length->deviation, 0.96);
  const PublishedFigure* never = find_published("occupancy-filters", "scans in which G(v) is confident occupied");
  ASSERT_NE(never, nullptr);
  EXPECT_TRUE(std::isnan(never->value));
}

TEST(Published, AStarStandsForAnyBeginningWithinItsExperiment) {
  EXPECT_NE(find_published("rbl-circle", "circle N=5 R=10 2d: success [-]"), nullptr);
  EXPECT_EQ(find_published("rbl-circle", "circle N=5 R=10 2d: success [-]; L [m], t [s]"), nullptr);
  EXPECT_EQ(find_published("rbl-peers", "sphere of 10 m: success [-]"), nullptr);
}

TEST(Published, EveryFigureBelongsToAnExperimentAndStandsOnce) {
  std::set<std::pair<std::string, std::string>> seen;
  for (const PublishedFigure& figure : published_figures()) {
    EXPECT_NO_THROW(experiment_type(figure.experiment)) << figure.experiment;
    EXPECT_TRUE(seen.emplace(figure.experiment, figure.what).second) << figure.experiment << ": " << figure.what;
    EXPECT_FALSE(figure.text.empty() || figure.source.empty()) << figure.what;
  }
  EXPECT_GT(seen.size(), 100U);
}

TEST(Published, ResultTablesInTheDocumentsShowTheSame) {
  std::string experiment;
  bool of_results = false;
  int compared = 0;
  for (const std::string& line : lines_of("reproduction.md")) {
    const std::size_t name = line.starts_with("##") ? line.find('`') : std::string::npos;
    if (name != std::string::npos) experiment = line.substr(name + 1, line.find('`', name + 1) - name - 1);
    const std::vector<std::string> cells = cells_of(line);
    if (cells.empty() || cells[0] == "what") of_results = !cells.empty();
    if (!of_results || cells[0] == "what" || cells[0] == "---") continue;
    const PublishedFigure* figure = find_published(experiment, cells[0]);
    ASSERT_GE(cells.size(), 5U) << line;
    EXPECT_EQ(cells[1], figure != nullptr ? figure->text : "-") << experiment << ": " << cells[0];
    compared += figure != nullptr ? 1 : 0;
    const std::string& verdict = cells[4];
    EXPECT_EQ(verdict == "no published figure", figure == nullptr) << experiment << ": " << cells[0];
    const bool judged = verdict == "reproduced" || verdict == "better" || verdict == "differs";
    EXPECT_TRUE(judged || verdict == "no published figure" || verdict == "other conditions") << line;
    EXPECT_FALSE(judged && cells[2].empty()) << "no tolerance: " << line;
  }
  EXPECT_GT(compared, 80);
}

// Compares the columns 2, 4 and 6 of the table that begins with the cell `first`; name(cells) is the row's name in
// published.csv without the quantity of the column. Returns the number of figures.
template <class Name>
int compare_columns(const std::string& document, const std::string& first, const std::string& experiment,
                    const std::array<std::string, 3>& quantities, Name&& name) {
  int compared = 0;
  bool within = false;
  for (const std::string& line : lines_of(document)) {
    const std::vector<std::string> cells = cells_of(line);
    if (cells.empty()) within = false;
    if (cells.size() < 8) continue;
    if (cells[0] == first) within = cells[2].ends_with(" published");
    if (!within || cells[0] == first || cells[0] == "---") continue;
    for (std::size_t i = 0; i < quantities.size(); ++i) {
      const PublishedFigure* figure = find_published(experiment, name(cells) + quantities[i]);
      EXPECT_NE(figure, nullptr) << line;
      if (figure != nullptr) EXPECT_EQ(cells[2 + 2 * i], figure->text) << line;
      ++compared;
    }
  }
  return compared;
}

TEST(Published, TheTablesOfCrossingsInTheDocumentsShowTheSame) {
  const auto name = [](const std::vector<std::string>& cells) { return "circle N=" + cells[0] + " R=10 " + cells[1]; };
  const std::array<std::string, 3> quantities = {": L [m]", ": t [s]", ": t_max [s]"};
  EXPECT_EQ(compare_columns("rbl.md", "N", "rbl-circle", quantities, name), 18);
  EXPECT_EQ(compare_columns("reproduction.md", "N", "rbl-circle", quantities, name), 36);
}

TEST(Published, TheTableOfUncertaintiesInTheDocumentsShowsTheSame) {
  const auto name = [](const std::vector<std::string>& cells) {
    return "mean, sigma_rad " + cells[0] + ", sigma_m " + cells[1] + " m, d ";
  };
  EXPECT_EQ(compare_columns("reproduction.md", "sigma_rad", "uncertainty-table", {"24 m", "48 m", "72 m"}, name), 27);
}

}  // namespace
}  // namespace swiftlet::tools
