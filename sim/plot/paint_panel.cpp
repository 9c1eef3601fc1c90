// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sim/plot/series.hpp"
#include "sim/plot/ticks.hpp"

namespace swiftlet::sim::plot {
namespace {

using Series = Panel::Series;

constexpr double kTick_px = 11.0, kLabel_px = 12.0, kTitle_px = 13.0, kLegend_px = 11.0;  // font sizes
constexpr double kLegendRow_px = 17.0, kLegendSwatch_px = 26.0;
constexpr const char* kInk = "#222";

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void include(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool empty() const { return low > high; }
};

// Maps data to pixels along one axis.
struct Scale {
  bool log = false;
  double low = 0.0, high = 1.0;        // data
  double px_low = 0.0, px_high = 1.0;  // pixels

  double at(double value) const {
    if (log && value <= 0.0) return std::numeric_limits<double>::quiet_NaN();
    const double t = log ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
    // Clamps positions far outside, which keeps the numbers short without visible difference.
    return px_low + std::clamp(t, -100.0, 100.0) * (px_high - px_low);
  }
};

struct Frame {
  double left = 0.0, top = 0.0, right = 0.0, bottom = 0.0;
  double width() const { return right - left; }
  double height() const { return bottom - top; }
};

struct View {
  Frame frame;
  Scale x, y;
  PointPx at(double data_x, double data_y) const { return {x.at(data_x), y.at(data_y)}; }
};

bool drawable(const PointPx& p) { return std::isfinite(p.x) && std::isfinite(p.y); }

std::string color_of(const Style& style) {
  const auto colors = palette();
  return colors[static_cast<std::size_t>(std::max(style.color, 0)) % colors.size()];
}

std::string stroke(const Style& style) {
  std::string text = "stroke=\"" + color_of(style) + "\" stroke-width=\"" + number_text(style.width_px, 2) + "\"";
  if (style.dash == Dash::kDashed) text += " stroke-dasharray=\"7 4\"";
  if (style.dash == Dash::kDotted) text += " stroke-dasharray=\"2 3\"";
  if (style.opacity < 1.0) text += " stroke-opacity=\"" + number_text(style.opacity, 2) + "\"";
  return text;
}

std::string fill(const Style& style, double opacity) {
  return "fill=\"" + color_of(style) + "\" fill-opacity=\"" + number_text(opacity * style.opacity, 2) + "\"";
}

// ---- data ranges ---------------------------------------------------------------------------------------------------

void include_x(const Series& s, Range& range) {
  for (const double value : s.x) range.include(value);
  if ((s.kind == kBars || s.kind == kBoxes) && !s.x.empty()) {
    range.include(-0.6);
    range.include(s.x.back() + 0.6);
  }
}

void include_y(const Series& s, Range& range) {
  if (s.kind == kVertical) return;
  for (const double value : s.y) range.include(value);
  for (const double value : s.low) range.include(value);
  for (const double value : s.high) range.include(value);
  for (const Box& box : s.boxes) {
    for (const double value : {box.low, box.high, box.mean}) range.include(value);
    for (const double value : box.outliers) range.include(value);
  }
}

bool has_kind(const Panel& panel, std::initializer_list<Kind> kinds) {
  return std::any_of(panel.series().begin(), panel.series().end(),
                     [&](const Series& s) { return std::find(kinds.begin(), kinds.end(), s.kind) != kinds.end(); });
}

/// True if a series has markers, which the edge of the frame would cut in half.
bool marks_ends(const Panel& panel) {
  return std::any_of(panel.series().begin(), panel.series().end(),
                     [](const Series& s) { return s.kind == kLine && s.style.marker != Marker::kNone; });
}

double smallest_positive(const Panel& panel, bool of_x) {
  Range range;
  for (const Series& s : panel.series()) {
    const auto take = [&](const std::vector<double>& values) {
      for (const double value : values) {
        if (value > 0.0) range.include(value);
      }
    };
    if (of_x) {
      take(s.x);
    } else {
      for (const auto* values : {&s.y, &s.low, &s.high}) take(*values);
      for (const Box& box : s.boxes) take({box.low, box.q1, box.median});
    }
  }
  return range.empty() ? 0.1 : range.low;
}

Range padded(Range range, const Axis& axis, bool tight, bool from_zero) {
  if (range.empty()) range = {0.0, 1.0};
  if (axis.log) {
    if (range.high <= range.low) range = {range.low / 2.0, range.high * 2.0};
    const double room = tight ? 1.0 : std::pow(range.high / range.low, 0.04);
    return {range.low / room, range.high * room};
  }
  // Include zero when the range begins near it.
  if (from_zero || (!tight && range.low > 0.0 && range.low < 0.35 * range.high)) range.include(0.0);
  // Values that differ only in their last bits are equal.
  if (range.high - range.low <= 1e-9 * std::max(std::abs(range.low), std::abs(range.high))) {
    const double half = std::max(std::abs(range.low) * 0.1, 0.5);
    return {range.low - half, range.high + half};
  }
  const double room = tight ? 0.0 : 0.05 * (range.high - range.low);
  return {range.low == 0.0 ? 0.0 : range.low - room, range.high == 0.0 ? 0.0 : range.high + room};
}

Range axis_range(const Panel& panel, bool of_x) {
  const Axis& axis = of_x ? panel.x : panel.y;
  Range range;
  for (const Series& s : panel.series()) of_x ? include_x(s, range) : include_y(s, range);
  if (axis.log) {
    range.low = smallest_positive(panel, of_x);
    range.high = std::max(range.high, range.low);
  }
  if (!axis.categories.empty()) {
    range.include(-0.6);
    range.include(static_cast<double>(axis.categories.size()) - 0.4);
  }
  const bool discrete = !axis.categories.empty() || (of_x && has_kind(panel, {kBars, kBoxes}));
  const bool tight = discrete || (of_x && !has_kind(panel, {kScatter}) && !marks_ends(panel));
  range = padded(range, axis, tight && !panel.equal_axes, !of_x && has_kind(panel, {kBars}));
  if (axis.min) range.low = *axis.min;
  if (axis.max) range.high = *axis.max;
  if (axis.log && range.low <= 0.0) range.low = range.high > 0.0 ? range.high * 1e-3 : 1e-3;
  if (!(range.high > range.low)) range.high = axis.log ? range.low * 10.0 : range.low + 1.0;
  return range;
}

std::vector<Tick> ticks_of(const Axis& axis, const Range& range, int wanted) {
  if (!axis.categories.empty()) {
    std::vector<Tick> ticks;
    for (std::size_t i = 0; i < axis.categories.size(); ++i)
      ticks.push_back({static_cast<double>(i), axis.categories[i]});
    return ticks;
  }
  return axis.log ? log_ticks(range.low, range.high, wanted) : linear_ticks(range.low, range.high, wanted);
}

double widest(const std::vector<Tick>& ticks) {
  double width = 0.0;
  for (const Tick& tick : ticks) width = std::max(width, text_width(tick.label, kTick_px));
  return width;
}

// ---- marks ---------------------------------------------------------------------------------------------------------

void draw_marker(SvgWriter& svg, PointPx p, const Style& style) {
  const double r = style.marker_px;
  const std::string ink = fill(style, 1.0);
  switch (style.marker) {
    case Marker::kNone:
      return;
    case Marker::kCircle:
      svg.circle(p, r, ink);
      return;
    case Marker::kSquare:
      svg.rect(p.x - r, p.y - r, 2.0 * r, 2.0 * r, ink);
      return;
    case Marker::kDiamond:
      svg.polygon({{p.x, p.y - 1.3 * r}, {p.x + 1.3 * r, p.y}, {p.x, p.y + 1.3 * r}, {p.x - 1.3 * r, p.y}}, ink);
      return;
  }
}

void draw_line(SvgWriter& svg, const Series& s, const View& view) {
  std::vector<PointPx> piece;
  for (std::size_t i = 0; i <= s.x.size(); ++i) {
    const PointPx p = i < s.x.size() ? view.at(s.x[i], s.y[i]) : PointPx{std::nan(""), 0.0};
    if (drawable(p)) {
      piece.push_back(p);
    } else {
      svg.polyline(piece, stroke(s.style));
      piece.clear();
    }
  }
  for (std::size_t i = 0; i < s.x.size() && s.style.marker != Marker::kNone; ++i) {
    const PointPx p = view.at(s.x[i], s.y[i]);
    if (drawable(p)) draw_marker(svg, p, s.style);
  }
}

void draw_band(SvgWriter& svg, const Series& s, const View& view) {
  std::vector<PointPx> lower, upper;
  for (std::size_t i = 0; i <= s.x.size(); ++i) {
    const bool end = i == s.x.size();
    const PointPx low = end ? PointPx{std::nan(""), 0.0} : view.at(s.x[i], s.low[i]);
    const PointPx high = end ? low : view.at(s.x[i], s.high[i]);
    if (drawable(low) && drawable(high)) {
      lower.push_back(low);
      upper.push_back(high);
      continue;
    }
    lower.insert(lower.end(), upper.rbegin(), upper.rend());
    svg.polygon(lower, fill(s.style, 0.22));
    lower.clear();
    upper.clear();
  }
}

// Bars and boxes side by side share the slot of a position.
struct Slot {
  double center_offset = 0.0, width = 0.8;
};

Slot slot_of(const Panel& panel, const Series& series) {
  int count = 0, index = 0;
  for (const Series& s : panel.series()) {
    if (s.kind != kBars && s.kind != kBoxes) continue;
    if (&s == &series) index = count;
    ++count;
  }
  const double width = 0.8 / std::max(count, 1);
  return {(index - 0.5 * (count - 1)) * width, width};
}

void draw_bars(SvgWriter& svg, const Series& s, const View& view, const Slot& slot) {
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    if (!std::isfinite(s.y[i])) continue;
    const double left = view.x.at(s.x[i] + slot.center_offset - 0.46 * slot.width);
    const double right = view.x.at(s.x[i] + slot.center_offset + 0.46 * slot.width);
    const double foot = view.y.log ? view.frame.bottom : view.y.at(0.0), top = view.y.at(s.y[i]);
    if (!std::isfinite(top)) continue;
    svg.rect(left, std::min(foot, top), right - left, std::abs(foot - top), fill(s.style, 0.85));
  }
}

void draw_boxes(SvgWriter& svg, const Series& s, const View& view, const Slot& slot) {
  for (std::size_t i = 0; i < s.boxes.size(); ++i) {
    const Box& box = s.boxes[i];
    const double center = s.x[i] + slot.center_offset;
    const double left = view.x.at(center - 0.36 * slot.width), right = view.x.at(center + 0.36 * slot.width);
    const double middle = view.x.at(center), q1 = view.y.at(box.q1), q3 = view.y.at(box.q3),
                 median = view.y.at(box.median);
    const std::string pen = stroke({.color = s.style.color, .width_px = 1.2});
    svg.segment({middle, view.y.at(box.low)}, {middle, q1}, pen);
    svg.segment({middle, q3}, {middle, view.y.at(box.high)}, pen);
    for (const double end : {box.low, box.high}) {
      svg.segment({0.5 * (left + middle), view.y.at(end)}, {0.5 * (right + middle), view.y.at(end)}, pen);
    }
    svg.rect(left, q3, right - left, q1 - q3, fill(s.style, 0.3) + " " + pen);
    svg.segment({left, median}, {right, median}, stroke({.color = s.style.color, .width_px = 2.4}));
    draw_marker(svg, {middle, view.y.at(box.mean)},
                {.color = s.style.color, .marker = Marker::kDiamond, .marker_px = 2.5});
    for (const double outlier : box.outliers) svg.circle({middle, view.y.at(outlier)}, 1.5, fill(s.style, 0.5));
  }
}

void draw_series(SvgWriter& svg, const Panel& panel, const Series& s, const View& view) {
  const Frame& frame = view.frame;
  switch (s.kind) {
    case kLine:
      draw_line(svg, s, view);
      return;
    case kBand:
      draw_band(svg, s, view);
      return;
    case kScatter:
      for (std::size_t i = 0; i < s.x.size(); ++i) {
        const PointPx p = view.at(s.x[i], s.y[i]);
        if (drawable(p)) draw_marker(svg, p, s.style);
      }
      return;
    case kBars:
      draw_bars(svg, s, view, slot_of(panel, s));
      return;
    case kBoxes:
      draw_boxes(svg, s, view, slot_of(panel, s));
      return;
    case kVertical:
      svg.segment({view.x.at(s.x[0]), frame.top}, {view.x.at(s.x[0]), frame.bottom}, stroke(s.style));
      return;
  }
}

// ---- legend --------------------------------------------------------------------------------------------------------

std::vector<const Series*> legend_entries(const Panel& panel) {
  std::vector<const Series*> entries;
  if (panel.legend == Legend::kNone) return entries;
  for (const Series& s : panel.series()) {
    if (!s.label.empty()) entries.push_back(&s);
  }
  return entries;
}

double legend_width(const std::vector<const Series*>& entries) {
  double width = 0.0;
  for (const Series* s : entries) width = std::max(width, text_width(s->label, kLegend_px));
  return width + kLegendSwatch_px + 16.0;
}

double legend_height(const std::vector<const Series*>& entries) {
  return static_cast<double>(entries.size()) * kLegendRow_px + 8.0;
}

void draw_swatch(SvgWriter& svg, const Series& s, PointPx middle) {
  const double half = 0.5 * kLegendSwatch_px - 3.0;
  if (s.kind == kBand || s.kind == kBars || s.kind == kBoxes) {
    std::string look = fill(s.style, s.kind == kBars ? 0.85 : 0.3);
    if (s.kind == kBoxes) look.append(" ").append(stroke({.color = s.style.color, .width_px = 1.2}));
    svg.rect(middle.x - half, middle.y - 5.0, 2.0 * half, 10.0, look);
    return;
  }
  if (s.kind != kScatter) svg.segment({middle.x - half, middle.y}, {middle.x + half, middle.y}, stroke(s.style));
  draw_marker(svg, middle, s.style);
}

void draw_legend(SvgWriter& svg, const std::vector<const Series*>& entries, double left, double top, bool framed) {
  if (framed)
    svg.rect(left, top, legend_width(entries), legend_height(entries),
             "fill=\"#fff\" fill-opacity=\"0.85\" stroke=\"#ccc\" stroke-width=\"0.8\"");
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const double y = top + 4.0 + (static_cast<double>(i) + 0.5) * kLegendRow_px;
    draw_swatch(svg, *entries[i], {left + 4.0 + 0.5 * kLegendSwatch_px, y});
    svg.text({left + kLegendSwatch_px + 8.0, y + 4.0}, entries[i]->label, kLegend_px, Anchor::kStart, kInk);
  }
}

// A sparse sample of the pixels covered by marks, to test whether a corner is free.
std::vector<PointPx> covered(const Panel& panel, const View& view) {
  std::vector<PointPx> points;
  const auto segment = [&](PointPx a, PointPx b) {
    if (!drawable(a) || !drawable(b)) return;
    const int count = std::clamp(static_cast<int>(std::hypot(b.x - a.x, b.y - a.y) / 4.0), 1, 400);
    for (int k = 0; k <= count; ++k) points.push_back({a.x + (b.x - a.x) * k / count, a.y + (b.y - a.y) * k / count});
  };
  for (const Series& s : panel.series()) {
    switch (s.kind) {
      case kLine:
        for (std::size_t i = 0; i + 1 < s.x.size(); ++i)
          segment(view.at(s.x[i], s.y[i]), view.at(s.x[i + 1], s.y[i + 1]));
        [[fallthrough]];
      case kScatter:
        for (std::size_t i = 0; i < s.x.size(); ++i) points.push_back(view.at(s.x[i], s.y[i]));
        break;
      case kBand:
        for (std::size_t i = 0; i + 1 < s.x.size(); ++i) {
          const PointPx low = view.at(s.x[i], s.low[i]), next_low = view.at(s.x[i + 1], s.low[i + 1]);
          const PointPx high = view.at(s.x[i], s.high[i]), next_high = view.at(s.x[i + 1], s.high[i + 1]);
          constexpr int kSlices = 8;
          for (int k = 0; k <= kSlices; ++k) {
            const double t = static_cast<double>(k) / kSlices, x = low.x + t * (next_low.x - low.x);
            segment({x, low.y + t * (next_low.y - low.y)}, {x, high.y + t * (next_high.y - high.y)});
          }
        }
        break;
      case kBars: {
        const double foot = view.y.log ? view.y.low : 0.0;
        for (const double side : {-0.4, 0.0, 0.4}) {
          for (std::size_t i = 0; i < s.x.size(); ++i)
            segment(view.at(s.x[i] + side, foot), view.at(s.x[i] + side, s.y[i]));
        }
        break;
      }
      case kBoxes:
        for (std::size_t i = 0; i < s.boxes.size(); ++i) {
          const Box& box = s.boxes[i];
          for (const double side : {-0.35, 0.0, 0.35})
            segment(view.at(s.x[i] + side, box.low), view.at(s.x[i] + side, box.high));
          for (const double outlier : box.outliers) points.push_back(view.at(s.x[i], outlier));
        }
        break;
      case kVertical:
        segment({view.x.at(s.x[0]), view.frame.top}, {view.x.at(s.x[0]), view.frame.bottom});
        break;
    }
  }
  return points;
}

// A corner of the frame without marks.
std::optional<PointPx> free_corner(const Panel& panel, const View& view, double width, double height) {
  const Frame& f = view.frame;
  if (width > 0.6 * f.width() || height > 0.6 * f.height()) return std::nullopt;
  const std::vector<PointPx> points = covered(panel, view);
  const std::array<PointPx, 4> corners{{{f.right - width - 6.0, f.top + 6.0},
                                        {f.left + 6.0, f.top + 6.0},
                                        {f.right - width - 6.0, f.bottom - height - 6.0},
                                        {f.left + 6.0, f.bottom - height - 6.0}}};
  for (const PointPx& corner : corners) {
    const bool touched = std::any_of(points.begin(), points.end(), [&](const PointPx& p) {
      return p.x > corner.x - 5.0 && p.x < corner.x + width + 5.0 && p.y > corner.y - 5.0 &&
             p.y < corner.y + height + 5.0;
    });
    if (!touched) return corner;
  }
  return std::nullopt;
}

// ---- frame ---------------------------------------------------------------------------------------------------------

// Equal axes: extends the smaller range about its middle.
void equalise(Range& x, Range& y, const Frame& frame) {
  const double meters_per_px = std::max((x.high - x.low) / frame.width(), (y.high - y.low) / frame.height());
  const auto grow = [&](Range& range, double pixels) {
    const double middle = 0.5 * (range.low + range.high), half = 0.5 * meters_per_px * pixels;
    range = {middle - half, middle + half};
  };
  grow(x, frame.width());
  grow(y, frame.height());
}

struct Layout {
  View view;
  std::vector<Tick> x_ticks, y_ticks;
  bool turned = false;  // category names are slanted
};

constexpr double kSlant = 0.5;  // sine of 30 degrees

Layout arrange(const Panel& panel, double left, double top, double width, double height, double beside) {
  Range x = axis_range(panel, true), y = axis_range(panel, false);
  Layout layout;
  layout.y_ticks = ticks_of(panel.y, y, std::max(2, static_cast<int>(height / 55.0)));
  Frame& frame = layout.view.frame;
  frame = {left + 14.0 + (panel.y.label.empty() ? 0.0 : 18.0) + widest(layout.y_ticks) + 6.0,
           top + (panel.title.empty() ? 12.0 : 30.0), left + width - 16.0 - beside,
           top + height - 24.0 - (panel.x.label.empty() ? 0.0 : 18.0)};
  if (panel.equal_axes) {
    equalise(x, y, frame);
    layout.y_ticks = ticks_of(panel.y, y, std::max(2, static_cast<int>(height / 55.0)));
  }
  layout.x_ticks = ticks_of(panel.x, x, std::max(2, static_cast<int>(frame.width() / 75.0)));
  const double slot = panel.x.categories.empty() ? 1e9 : frame.width() / static_cast<double>(panel.x.categories.size());
  if (widest(layout.x_ticks) > slot - 4.0) {
    layout.turned = true;
    frame.bottom -= std::min(kSlant * widest(layout.x_ticks), 0.35 * height);
  }
  layout.view.x = {panel.x.log, x.low, x.high, frame.left, frame.right};
  layout.view.y = {panel.y.log, y.low, y.high, frame.bottom, frame.top};
  return layout;
}

void draw_axes(SvgWriter& svg, const Panel& panel, const Layout& layout, double left, double bottom) {
  const Frame& f = layout.view.frame;
  for (const Tick& tick : layout.x_ticks) {
    const double x = layout.view.x.at(tick.value);
    if (x < f.left - 0.5 || x > f.right + 0.5) continue;
    const bool minor = tick.label.empty();
    if (panel.x.categories.empty())
      svg.segment({x, f.top}, {x, f.bottom}, minor ? "stroke=\"#f1f1f1\"" : "stroke=\"#dedede\"");
    svg.segment({x, f.bottom}, {x, f.bottom + (minor ? 2.5 : 4.5)}, "stroke=\"#222\"");
    const PointPx at{x + (layout.turned ? 4.0 : 0.0), f.bottom + 17.0};
    svg.text(at, tick.label, kTick_px, layout.turned ? Anchor::kEnd : Anchor::kMiddle, kInk,
             layout.turned ? -30.0 : 0.0);
  }
  for (const Tick& tick : layout.y_ticks) {
    const double y = layout.view.y.at(tick.value);
    if (y < f.top - 0.5 || y > f.bottom + 0.5) continue;
    const bool minor = tick.label.empty();
    svg.segment({f.left, y}, {f.right, y}, minor ? "stroke=\"#f1f1f1\"" : "stroke=\"#dedede\"");
    svg.segment({f.left - (minor ? 2.5 : 4.5), y}, {f.left, y}, "stroke=\"#222\"");
    svg.text({f.left - 7.0, y + 4.0}, tick.label, kTick_px, Anchor::kEnd, kInk);
  }
  svg.text({0.5 * (f.left + f.right), bottom - 8.0}, panel.x.label, kLabel_px, Anchor::kMiddle, kInk);
  svg.text({left + 20.0, 0.5 * (f.top + f.bottom)}, panel.y.label, kLabel_px, Anchor::kMiddle, kInk, -90.0);
}

}  // namespace

void paint_panel(SvgWriter& svg, const Panel& panel, double left, double top, double width, double height) {
  const std::vector<const Series*> entries = legend_entries(panel);
  Layout layout = arrange(panel, left, top, width, height, 0.0);
  std::optional<PointPx> corner;
  if (!entries.empty()) {
    if (panel.legend == Legend::kAuto)
      corner = free_corner(panel, layout.view, legend_width(entries), legend_height(entries));
    if (!corner) layout = arrange(panel, left, top, width, height, legend_width(entries) + 4.0);
  }

  const Frame& f = layout.view.frame;
  svg.text({0.5 * (f.left + f.right), top + 19.0}, panel.title, kTitle_px, Anchor::kMiddle, "#111", 0.0, true);
  draw_axes(svg, panel, layout, left, top + height);
  svg.begin_clip(f.left, f.top, f.width(), f.height());
  for (const Series& s : panel.series()) draw_series(svg, panel, s, layout.view);
  svg.end_clip();
  svg.rect(f.left, f.top, f.width(), f.height(), "fill=\"none\" stroke=\"#222\"");
  if (entries.empty()) return;
  if (corner) {
    draw_legend(svg, entries, corner->x, corner->y, true);
  } else {
    draw_legend(svg, entries, f.right + 10.0, f.top, false);
  }
}

}  // namespace swiftlet::sim::plot
