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

/// How the writing on a picture looks.
struct Look {
  float text_px = 12.0F;  ///< height of capitals
  Rgb ink = Rgb::Constant(0.08F);
  Rgb page = Rgb::Ones();            ///< margins, and halos of what is drawn over the picture
  Rgb nothing{0.82F, 0.88F, 0.95F};  ///< pixels without a measured depth or range; no gray, which means something
  bool captions = true;              ///< scenario, camera and time at the lower edge
  float line_scale = 1.0F;           ///< lines are wider by this on paper of many pixels

  TextStyle text(float share = 1.0F, Align align = Align::kLeft) const;
};
Look look_of(const CameraConfig& camera);

/// Two lines of text at the lower edge of an area as wide as this: at the left what it is, at the right when. Where
/// both do not fit, the left one is left out.
void draw_caption(Canvas& canvas, const Look& look, int width_px, std::string_view left, std::string_view right);
/// A bar of round length in the lower left corner, above the caption. For parallel projections.
void draw_scale_bar(Canvas& canvas, const Look& look, const View& view);
/// How the axes of the world lie, in the lower right corner, above the caption.
void draw_axes(Canvas& canvas, const Look& look, const View& view);

/// How vehicles are told on a picture.
struct VehicleMarks {
  std::span<const std::string> names;  ///< empty: none
  std::span<const float> radii_m;      ///< circumscribed, as drawn
  float min_px = 0.0F;                 ///< smaller ones get a ring of this diameter
  VehicleId hidden_vehicle = kNoVehicle;
};
/// Each vehicle's name in its color, and rings around those that are too small to be seen. A name stands above its
/// vehicle. Where it would cover another name, a vehicle, scale bar, axes or caption, it stands below, right or left.
void draw_vehicle_marks(Canvas& canvas, const Look& look, const View& view, const PictureScene& picture,
                        const VehicleMarks& marks);

/// A bar that explains colors.
struct ColorBar {
  std::function<Rgb(float)> color;  ///< of s in 0..1
  double low = 0.0;                 ///< value at s = 0
  double high = 1.0;
  std::string unit;
};

/// How a legend shows a thing: as it is drawn in the picture.
enum class Sample { kSquare, kDisc, kDot, kLine, kDashes };
Sample sample_of(Overlay::Kind kind, bool dashed);

struct LegendEntry {
  std::string meaning;
  Rgb color = Rgb::Zero();
  Sample sample = Sample::kSquare;
};
/// Least color_difference() of two rows of a legend with the same kind of sample.
inline constexpr float kLeastDifference = 0.1F;
/// The rows of a legend: each meaning once. Entries that look alike share a row, so all rows can be told apart.
std::vector<LegendEntry> rows_of(std::span<const LegendEntry> entries);

/// What stands in the margin at the right of a picture: what colors mean, and a bar below.
struct Sidebar {
  std::vector<LegendEntry> entries;
  std::optional<ColorBar> bar;

  bool empty() const { return entries.empty() && !bar; }
};
/// 0: nothing to show. Hangs on the words, not on the values along the bar as long as they have few digits.
int sidebar_width_px(const Sidebar& sidebar, const Look& look);
/// Fills the canvas from `left_px` to its right edge. Rows that find no room are counted in the last line.
void draw_sidebar(Canvas& canvas, const Look& look, const Sidebar& sidebar, int left_px);

/// Where everything of a sidebar lies.
struct SidebarLayout {
  struct Row {
    Box swatch;
    LegendEntry entry;
    std::vector<std::string> lines;
    float first_baseline_px = 0.0F;
  };
  float text_px = 0.0F;
  float line_px = 0.0F;  ///< from a baseline to the next
  float text_left_px = 0.0F;
  std::vector<Row> rows;
  std::size_t left_out = 0;  ///< rows that find no room
  float left_out_baseline_px = 0.0F;
  Box bar;  ///< empty: none
  float unit_baseline_px = 0.0F;
  double tick_step = 1.0;
  std::vector<double> ticks;
};
SidebarLayout lay_out(const Sidebar& sidebar, const Look& look, const Box& margin);

/// 1, 2 or 5 times a power of ten, the largest not above x (x > 0).
double round_down_nicely(double x);
/// Shortest decimal of a tick at steps of `step`.
std::string tick_text(double value, double step);

/// End of the color scale of a depth image [m]: most of what is seen, up to a round number.
double depth_scale_end_m(const DepthImage& depth);
/// Colors of turbo_like from 0 to max_range_m.
Image depth_colors(const DepthImage& depth, double max_range_m, const Rgb& nothing);

}  // namespace swiftlet::sim
