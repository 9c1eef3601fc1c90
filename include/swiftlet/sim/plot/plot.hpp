// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// Plots as SVG text; equal figures give equal bytes on every machine.
///
///   plot::Figure figure("Expected error");
///   plot::Panel& panel = figure.add_panel("sigma_rad = 5 mrad");
///   panel.x.label = "range [m]";
///   panel.line("theory", range_m, error_m).scatter("simulated", bin_m, mean_m);
///   figure.write("error.svg");
namespace swiftlet::sim::plot {

enum class Dash { kSolid, kDashed, kDotted };
enum class Marker { kNone, kCircle, kSquare, kDiamond };
enum class Legend { kAuto, kOutside, kNone };  ///< auto: a free corner if there is one, beside the panel otherwise

struct Style {
  int color = -1;  ///< index of palette(), any number (it wraps); -1: the panel's next
  double width_px = 1.8;
  Dash dash = Dash::kSolid;
  Marker marker = Marker::kNone;  ///< kNone: scatter() draws circles
  double marker_px = 3.0;         ///< radius
  double opacity = 1.0;
};

/// Colors distinguishable on white with any color vision (Okabe and Ito, 2008, without the yellow).
std::span<const char* const> palette();

struct Axis {
  std::string label;                    ///< with unit: "range [m]"
  bool log = false;                     ///< logarithmic, by decades; values <= 0 are omitted
  std::optional<double> min, max;       ///< unset: from the data
  std::vector<std::string> categories;  ///< names of the positions 0, 1, 2, ... instead of numbers
};

/// Quartiles (linear interpolation), whiskers at the last sample within 1.5 interquartile ranges (Tukey).
struct Box {
  double low = 0.0, q1 = 0.0, median = 0.0, q3 = 0.0, high = 0.0, mean = 0.0;
  std::vector<double> outliers;
};
/// @param samples  not empty; NaN is omitted
Box box_of(std::span<const double> samples);

/// One coordinate system. A label names the series in the legend; series with an empty label are not listed. NaN breaks
/// a line and drops any other mark. All spans of a call must have equal length, otherwise std::invalid_argument is
/// thrown.
class Panel {
 public:
  std::string title;
  Axis x, y;
  Legend legend = Legend::kAuto;
  bool equal_axes = false;  ///< equal scale in x and y, for maps and top views

  using Values = std::span<const double>;
  Panel& line(const std::string& label, Values x, Values y, const Style& style = {});
  Panel& band(const std::string& label, Values x, Values low, Values high, const Style& style = {});
  Panel& scatter(const std::string& label, Values x, Values y, const Style& style = {});
  /// Bars at positions 0, 1, 2, ...; several bar or box series of a panel stand side by side.
  Panel& bars(const std::string& label, Values heights, const Style& style = {});
  Panel& boxes(const std::string& label, std::vector<Box> boxes, const Style& style = {});
  Panel& vertical(const std::string& label, double x, const Style& style = {});

  struct Series;  ///< defined in plot.cpp
  Panel();
  ~Panel();
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;
  const std::vector<Series>& series() const { return series_; }

 private:
  Series& add(int kind, const std::string& label, const Style& style);
  std::vector<Series> series_;
  int next_color_ = 0;
};

/// Panels in a grid, row by row.
class Figure {
 public:
  explicit Figure(std::string title = {}, int columns = 1);
  /// Size of one panel including axes and labels.
  void set_panel_size(double width_px, double height_px);
  Panel& add_panel(const std::string& title = {});
  std::string svg() const;
  /// Creates missing folders. Throws std::runtime_error with path and reason.
  void write(const std::filesystem::path& path) const;

 private:
  std::string title_;
  int columns_ = 1;
  double panel_width_px_ = 560.0, panel_height_px_ = 380.0;
  std::deque<Panel> panels_;
};

}  // namespace swiftlet::sim::plot
