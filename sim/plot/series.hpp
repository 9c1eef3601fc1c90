// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "sim/plot/plot.hpp"
#include "sim/plot/svg_writer.hpp"

namespace swiftlet::sim::plot {

enum Kind { kLine, kBand, kScatter, kErrorBars, kBars, kBoxes, kHorizontal, kVertical, kText, kHeatMap };

/// What one call of a Panel added.
struct Panel::Series {
  Kind kind = kLine;
  std::string label;
  Style style;
  std::vector<double> x, y;       ///< of bars: position, height; of a heat map: the edges
  std::vector<double> low, high;  ///< of bands and error bars; of a heat map `low` holds the values
  std::vector<Box> boxes;
};

/// Draws a panel into the rectangle whose upper left corner is (left, top).
void paint_panel(SvgWriter& svg, const Panel& panel, double left, double top, double width, double height);

/// Dark to bright, 0 <= t <= 1, also ordered without color vision (Viridis).
std::string heat_color(double t);

}  // namespace swiftlet::sim::plot
