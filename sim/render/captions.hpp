// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/render/cameras.hpp"
#include "sim/render/canvas.hpp"
#include "sim/render/picture_scene.hpp"

namespace swiftlet::sim {

/// Style of texts on a picture.
struct Look {
  float text_px = 12.0F;  ///< height of capitals
  Rgb ink = Rgb::Constant(0.08F);
  Rgb page = Rgb::Ones();            ///< color of margins, and of halos around drawn text
  Rgb nothing{0.82F, 0.88F, 0.95F};  ///< pixels without a measured depth or range; not gray, since gray encodes values
  bool captions = true;              ///< scenario, camera and time at the lower edge
  float line_scale = 1.0F;           ///< widening of lines on paper of many pixels

  TextStyle text(float share = 1.0F, Align align = Align::kLeft) const;
};
Look look_of(const CameraConfig& camera);

/// Two texts at the lower edge of an area of this width: description at the left, time at the right. Where both do not
/// fit, the left one is omitted.
void draw_caption(Canvas& canvas, const Look& look, int width_px, std::string_view left, std::string_view right);
/// A scale bar of round length in the lower left corner, above the caption. For parallel projections.
void draw_scale_bar(Canvas& canvas, const Look& look, const View& view);
/// Directions of the world axes, in the lower right corner, above the caption.
void draw_axes(Canvas& canvas, const Look& look, const View& view);

/// Labels of vehicles on a picture.
struct VehicleMarks {
  std::span<const std::string> names;  ///< empty: no names
  std::span<const float> radii_m;      ///< circumscribed radius, as drawn
  float min_px = 0.0F;                 ///< smaller vehicles get a ring of this diameter
  VehicleId hidden_vehicle = kNoVehicle;
};
/// Draws each vehicle's name in its color, and rings around vehicles that are too small. A name is placed above its
/// vehicle, or below, right or left where it would cover another name, a vehicle, scale bar, axes or caption.
void draw_vehicle_marks(Canvas& canvas, const Look& look, const View& view, const PictureScene& picture,
                        const VehicleMarks& marks);

/// Color scale of a picture.
struct ColorBar {
  std::function<Rgb(float)> color;  ///< argument in 0..1
  double low = 0.0;                 ///< value at s = 0
  double high = 1.0;
  std::string unit;
};

/// Symbol in a legend, drawn as in the picture.
enum class Sample { kSquare, kDisc, kDot, kLine, kDashes };
Sample sample_of(Overlay::Kind kind, bool dashed);

struct LegendEntry {
  std::string meaning;
  Rgb color = Rgb::Zero();
  Sample sample = Sample::kSquare;
};
/// Least color_difference() between two rows of a legend with the same symbol.
inline constexpr float kMinDifference = 0.1F;
/// Rows of a legend, one per meaning. Entries of similar appearance share a row, so all rows are distinguishable.
std::vector<LegendEntry> rows_of(std::span<const LegendEntry> entries);

/// Content of the margin at the right of a picture: meanings of colors, and a color bar below.
struct Sidebar {
  std::vector<LegendEntry> entries;
  std::optional<ColorBar> bar;

  bool empty() const { return entries.empty() && !bar; }
};
/// 0: empty. Independent of the values along the bar as long as they have few digits.
int sidebar_width_px(const Sidebar& sidebar, const Look& look);
/// Fills the canvas from `left_px` to its right edge. Rows without space are counted in the last line.
void draw_sidebar(Canvas& canvas, const Look& look, const Sidebar& sidebar, int left_px);

/// Positions of all parts of a sidebar.
struct SidebarLayout {
  struct Row {
    Box swatch;
    LegendEntry entry;
    std::vector<std::string> lines;
    float first_baseline_px = 0.0F;
  };
  float text_px = 0.0F;
  float line_px = 0.0F;  ///< distance between baselines
  float text_left_px = 0.0F;
  std::vector<Row> rows;
  std::size_t left_out = 0;  ///< number of rows without space
  float left_out_baseline_px = 0.0F;
  Box bar;  ///< empty: no bar
  float unit_baseline_px = 0.0F;
  double tick_step = 1.0;
  std::vector<double> ticks;
};
SidebarLayout lay_out(const Sidebar& sidebar, const Look& look, const Box& margin);

/// The largest 1, 2 or 5 times a power of ten not above x (x > 0).
double round_down_nicely(double x);
/// Shortest decimal text of a tick at steps of `step`.
std::string tick_text(double value, double step);

/// End of the color scale of a depth image [m]: covers most of its pixels, rounded up.
double depth_scale_end_m(const DepthImage& depth);
/// Image in colors of turbo_like from 0 to max_range_m.
Image depth_colors(const DepthImage& depth, double max_range_m, const Rgb& nothing);

}  // namespace swiftlet::sim
