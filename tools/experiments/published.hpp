// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <string_view>

/// Published figures: published.csv is the one table that experiments compare with and that tests compare the pages
/// with. A row name that begins with * matches every name with that ending.
namespace swiftlet::tools {

struct PublishedFigure {
  std::string experiment;
  std::string what;  ///< the row of the experiment's result table
  std::string text;  ///< as printed: "91.99 ± 0.96", "never"
  std::string source;
  double value = 0.0, deviation = 0.0;  ///< the numbers in the text; NaN where there is none
};

std::span<const PublishedFigure> published_figures();

/// nullptr without a published figure.
const PublishedFigure* find_published(std::string_view experiment, std::string_view what);

}  // namespace swiftlet::tools
