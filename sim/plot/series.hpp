// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/sim/plot/plot.hpp"
#include "swiftlet/sim/plot/svg_writer.hpp"

namespace swiftlet::sim::plot {

enum Kind { kLine, kBand, kScatter, kBars, kBoxes, kHorizontal, kVertical, kText };

/// What one call of a Panel added.
struct Panel::Series {
  Kind kind = kLine;
  std::string label;
  Style style;
  std::vector<double> x, y;       ///< of bars: position, height
  std::vector<double> low, high;  ///< of bands
  std::vector<Box> boxes;
};

/// Draws a panel into the rectangle whose upper left corner is (left, top).
void paint_panel(SvgWriter& svg, const Panel& panel, double left, double top, double width, double height);

}  // namespace swiftlet::sim::plot
