// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/sim/plot/plot.hpp"
#include "swiftlet/sim/plot/svg_writer.hpp"

namespace swiftlet::sim::plot {

enum Kind { kLine, kBand, kScatter, kBars, kBoxes, kVertical };

/// One series of a Panel.
struct Panel::Series {
  Kind kind = kLine;
  std::string label;
  Style style;
  std::vector<double> x, y;       ///< bars: position, height
  std::vector<double> low, high;  ///< lower and upper edges of bands
  std::vector<Box> boxes;
};

/// Draws a panel into the rectangle with upper left corner (left, top).
void paint_panel(SvgWriter& svg, const Panel& panel, double left, double top, double width, double height);

}  // namespace swiftlet::sim::plot
