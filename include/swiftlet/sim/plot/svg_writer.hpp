// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace swiftlet::sim::plot {

struct PointPx {
  double x = 0.0, y = 0.0;
};

enum class Anchor { kStart, kMiddle, kEnd };

/// Elements of one SVG picture; coordinates in pixels, y down, rounded to a tenth of a pixel.
class SvgWriter {
 public:
  /// @param width_mm  printed width; 0: unspecified
  SvgWriter(double width_px, double height_px, std::string_view title, double width_mm = 0.0);

  void rect(double x, double y, double width, double height, std::string_view attributes);
  void segment(PointPx a, PointPx b, std::string_view attributes);
  void circle(PointPx center, double radius, std::string_view attributes);
  /// Omits points equal to their predecessor. Of many points in one pixel column, only first, extremes and last are
  /// kept.
  void polyline(const std::vector<PointPx>& points, std::string_view attributes);
  void polygon(const std::vector<PointPx>& points, std::string_view attributes);
  /// @param turn_deg  clockwise about the anchor
  void text(PointPx at, std::string_view content, double size_px, Anchor anchor, std::string_view color = "#222",
            double turn_deg = 0.0, bool bold = false);
  /// As text(), with arbitrary attributes instead of a color.
  void text_with(PointPx at, std::string_view content, double size_px, Anchor anchor, std::string_view attributes);
  /// A PNG file, scaled to the rectangle.
  void picture(double x, double y, double width, double height, std::string_view png);
  /// Elements until end_clip() are visible only inside this rectangle.
  void begin_clip(double x, double y, double width, double height);
  void end_clip();
  std::string finish();

 private:
  void begin_text(PointPx at, double size_px);
  void add_anchor(Anchor anchor);
  void end_text(std::string_view content);

  std::string out_;
};

/// Estimated width in the fonts of the pictures.
double text_width(std::string_view content, double size_px);

}  // namespace swiftlet::sim::plot
