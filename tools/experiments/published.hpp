// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <string_view>

/// What was published: published.csv, the one table that experiments compare with and that the tests hold the documents
/// to. A name that begins with * stands for all that end so.
namespace swiftlet::tools {

struct PublishedFigure {
  std::string experiment;
  std::string what;  ///< the row of the experiment's result table
  std::string text;  ///< as printed: "91.99 ± 0.96", "never"
  std::string source;
  double value = 0.0, deviation = 0.0;  ///< the numbers in the text; NaN where there is none
};

std::span<const PublishedFigure> published_figures();

/// nullptr where nothing was published.
const PublishedFigure* find_published(std::string_view experiment, std::string_view what);

}  // namespace swiftlet::tools
