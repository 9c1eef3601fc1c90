// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/plot/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "sim/plot/series.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim::plot {
namespace {

constexpr double kFigureTitle_px = 34.0;  // height of the figure's title

void need_same_length(const std::string& label, std::initializer_list<std::size_t> sizes) {
  const bool same = std::all_of(sizes.begin(), sizes.end(), [&](std::size_t size) { return size == *sizes.begin(); });
  if (!same) throw std::invalid_argument("plot: series '" + label + "': expected as many x as y values");
}

std::vector<double> copied(Panel::Values values) { return {values.begin(), values.end()}; }

// Positions 0, 1, 2, ...
std::vector<double> positions(std::size_t count) {
  std::vector<double> x(count);
  std::iota(x.begin(), x.end(), 0.0);
  return x;
}

double quantile(const std::vector<double>& sorted, double p) {
  const double place = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

std::span<const char* const> palette() {
  static constexpr std::array<const char*, 7> kColors{"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                      "#E69F00", "#56B4E9", "#333333"};
  return kColors;
}

Box box_of(std::span<const double> samples) {
  std::vector<double> sorted;
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(sorted), [](double s) { return !std::isnan(s); });
  if (sorted.empty()) throw std::invalid_argument("plot: a box needs at least one sample");
  std::sort(sorted.begin(), sorted.end());
  Box box;
  box.q1 = quantile(sorted, 0.25);
  box.median = quantile(sorted, 0.5);
  box.q3 = quantile(sorted, 0.75);
  box.mean = std::accumulate(sorted.begin(), sorted.end(), 0.0) / static_cast<double>(sorted.size());
  const double reach = 1.5 * (box.q3 - box.q1);
  box.low = *std::find_if(sorted.begin(), sorted.end(), [&](double s) { return s >= box.q1 - reach; });
  box.high = *std::find_if(sorted.rbegin(), sorted.rend(), [&](double s) { return s <= box.q3 + reach; });
  for (const double s : sorted) {
    if (s < box.low || s > box.high) box.outliers.push_back(s);
  }
  return box;
}

Panel::Panel() = default;
Panel::~Panel() = default;

Panel::Series& Panel::add(int kind, const std::string& label, const Style& style) {
  Series& series = series_.emplace_back();
  series.kind = static_cast<Kind>(kind);
  series.label = label;
  series.style = style;
  if (style.color < 0) series.style.color = next_color_++;
  return series;
}

Panel& Panel::line(const std::string& label, Values xs, Values ys, const Style& style) {
  need_same_length(label, {xs.size(), ys.size()});
  Series& series = add(kLine, label, style);
  series.x = copied(xs);
  series.y = copied(ys);
  return *this;
}

Panel& Panel::band(const std::string& label, Values xs, Values low, Values high, const Style& style) {
  need_same_length(label, {xs.size(), low.size(), high.size()});
  Series& series = add(kBand, label, style);
  series.x = copied(xs);
  series.low = copied(low);
  series.high = copied(high);
  return *this;
}

Panel& Panel::scatter(const std::string& label, Values xs, Values ys, const Style& style) {
  need_same_length(label, {xs.size(), ys.size()});
  Series& series = add(kScatter, label, style);
  series.x = copied(xs);
  series.y = copied(ys);
  if (series.style.marker == Marker::kNone) series.style.marker = Marker::kCircle;
  return *this;
}

Panel& Panel::bars(const std::string& label, Values heights, const Style& style) {
  Series& series = add(kBars, label, style);
  series.x = positions(heights.size());
  series.y = copied(heights);
  return *this;
}

Panel& Panel::boxes(const std::string& label, std::vector<Box> boxes, const Style& style) {
  Series& series = add(kBoxes, label, style);
  series.x = positions(boxes.size());
  series.boxes = std::move(boxes);
  return *this;
}

Panel& Panel::vertical(const std::string& label, double at, const Style& style) {
  add(kVertical, label, style).x = {at};
  return *this;
}

Figure::Figure(std::string title, int columns) : title_(std::move(title)), columns_(std::max(columns, 1)) {}

void Figure::set_panel_size(double width_px, double height_px) {
  panel_width_px_ = width_px;
  panel_height_px_ = height_px;
}

Panel& Figure::add_panel(const std::string& title) {
  Panel& panel = panels_.emplace_back();
  panel.title = title;
  return panel;
}

std::string Figure::svg() const {
  const int count = static_cast<int>(panels_.size());
  const int columns = std::clamp(count, 1, columns_);
  const int rows = (count + columns - 1) / columns;
  const double top = title_.empty() ? 0.0 : kFigureTitle_px;
  const double width = columns * panel_width_px_;
  SvgWriter svg(width, top + rows * panel_height_px_, title_);
  svg.text({width / 2.0, 23.0}, title_, 15.0, Anchor::kMiddle, "#111", 0.0, true);
  for (int i = 0; i < count; ++i) {
    paint_panel(svg, panels_[static_cast<std::size_t>(i)], (i % columns) * panel_width_px_,
                top + (i / columns) * panel_height_px_, panel_width_px_, panel_height_px_);
  }
  return svg.finish();
}

void Figure::write(const std::filesystem::path& path) const { write_file(path, svg(), MissingFolders::kMade); }

}  // namespace swiftlet::sim::plot
