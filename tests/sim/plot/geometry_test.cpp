// SPDX-License-Identifier: BSD-3-Clause
// Where everything of a plot lies: each element of the SVG text measured against the frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "sim/plot/series.hpp"
#include "sim/plot/ticks.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::sim::plot {
namespace {

using Values = std::vector<double>;

/// One element with its attributes.
struct Element {
  std::string line;

  bool is(const std::string& tag) const { return line.rfind("<" + tag + " ", 0) == 0; }
  bool has(const std::string& part) const { return line.find(part) != std::string::npos; }
  std::string get(const std::string& name) const {
    const std::size_t at = line.find(" " + name + "=\"");
    if (at == std::string::npos) return "";
    const std::size_t begin = at + name.size() + 3;
    return line.substr(begin, line.find('"', begin) - begin);
  }
  double num(const std::string& name) const {
    const std::string text = get(name);
    return text.empty() ? std::nan("") : std::stod(text);
  }
  std::string content() const {
    const std::size_t begin = line.find('>') + 1;
    return line.substr(begin, line.rfind("</") - begin);
  }
  /// Of a polyline, a polygon, or a path of one segment.
  std::vector<PointPx> points() const {
    std::string text = is("path") ? get("d") : get("points");
    for (char& c : text) c = c == 'M' || c == 'L' || c == ',' ? ' ' : c;
    std::istringstream in(text);
    std::vector<PointPx> found;
    for (PointPx p; in >> p.x >> p.y;) found.push_back(p);
    return found;
  }
};

struct Drawing {
  std::vector<Element> elements;
  Element frame;

  explicit Drawing(const std::string& svg) {
    std::istringstream in(svg);
    for (std::string line; std::getline(in, line);) elements.push_back({line});
    for (const Element& e : elements) {
      if (e.is("rect") && e.has("fill=\"none\"") && e.has("stroke=\"#222\"")) frame = e;
    }
  }
  double left() const { return frame.num("x"); }
  double top() const { return frame.num("y"); }
  double width() const { return frame.num("width"); }
  double height() const { return frame.num("height"); }
  double right() const { return left() + width(); }
  double bottom() const { return top() + height(); }

  std::vector<Element> all(const std::string& tag, const std::string& part = "") const {
    std::vector<Element> found;
    for (const Element& e : elements) {
      if (e.is(tag) && e.has(part)) found.push_back(e);
    }
    return found;
  }
  Element text(const std::string& content) const {
    for (const Element& e : elements) {
      if (e.is("text") && e.content() == content) return e;
    }
    return {};
  }
  /// Shares of the frame, from its lower left corner.
  PointPx in_frame(const PointPx& p) const { return {(p.x - left()) / width(), (bottom() - p.y) / height()}; }
};

template <class Fill>
Drawing drawn(const Fill& fill, double width = 400.0, double height = 300.0) {
  Panel panel;
  fill(panel);
  SvgWriter svg(width, height, "");
  paint_panel(svg, panel, 0.0, 0.0, width, height);
  return Drawing(svg.finish());
}

/// Of a line's points, by the shares of the frame.
std::vector<PointPx> shares_of(const Drawing& drawing) {
  std::vector<PointPx> shares;
  const auto lines = drawing.all("polyline");
  if (lines.empty()) return shares;
  for (const PointPx& p : lines[0].points()) shares.push_back(drawing.in_frame(p));
  return shares;
}

constexpr double kPx = 0.06;     // coordinates are written to a tenth
constexpr double kShare = 5e-4;  // of a frame of some hundred pixels

void expect_near(double found, double expected, double share) {  // both-sided, closer than any factor of a half
  EXPECT_NEAR(found, expected, share * std::abs(expected) + kPx);
}

// ---- The frame.

TEST(PlotFrame, LeavesRoomForNumbersLabelsAndATitle) {
  const Values x{0, 1}, y{0, 1};
  const auto with = [&](const std::string& title, const std::string& x_label, const std::string& y_label) {
    return drawn([&](Panel& panel) {
      panel.title = title;
      panel.x.label = x_label;
      panel.y.label = y_label;
      panel.line("", x, y);
    });
  };
  const Drawing plain = with("", "", "");
  const double numbers = 3.0 * 0.6 * 11.0;  // "0.2": three letters of six tenths of their size
  expect_near(plain.left() - numbers, 20.0, 0.2);
  expect_near(plain.top(), 12.0, 0.2);
  expect_near(400.0 - plain.right(), 16.0, 0.2);
  expect_near(300.0 - plain.bottom(), 24.0, 0.15);
  const Drawing titled = with("title", "", "");
  expect_near(titled.top(), 30.0, 0.15);
  EXPECT_EQ(titled.left(), plain.left());
  const Drawing labeled = with("", "range [m]", "error [m]");
  expect_near(labeled.left() - plain.left(), 18.0, 0.2);
  expect_near(plain.bottom() - labeled.bottom(), 18.0, 0.2);
  EXPECT_EQ(labeled.top(), plain.top());
  EXPECT_EQ(labeled.right(), plain.right());

  // They stand in that room, in the middle of what they name.
  const Element title = titled.text("title"), below = labeled.text("range [m]"), beside = labeled.text("error [m]");
  expect_near(title.num("x"), 0.5 * (titled.left() + titled.right()), 0.001);
  EXPECT_LT(title.num("y"), titled.top() - 6.0);
  EXPECT_GT(title.num("y") - title.num("font-size"), 2.0);
  EXPECT_EQ(title.get("font-weight"), "bold");
  EXPECT_EQ(title.get("text-anchor"), "middle");
  expect_near(below.num("x"), 0.5 * (labeled.left() + labeled.right()), 0.001);
  expect_near(300.0 - below.num("y"), 8.0, 0.3);
  EXPECT_GT(below.num("y") - below.num("font-size"), labeled.bottom() + 18.0) << "below the numbers";
  expect_near(beside.num("x"), 20.0, 0.2);
  expect_near(beside.num("y"), 0.5 * (labeled.top() + labeled.bottom()), 0.001);
  EXPECT_TRUE(beside.get("transform").rfind("rotate(-90 ", 0) == 0) << beside.line;
  EXPECT_EQ(below.get("transform"), "");
  EXPECT_NEAR(title.num("font-size"), 13.0, 2.0);
  EXPECT_NEAR(below.num("font-size"), 12.0, 2.0);
  EXPECT_NEAR(plain.text("0.2").num("font-size"), 11.0, 2.0);
}

TEST(PlotFrame, HasTicksOutsideGridLinesInsideAndNumbersAtThem) {
  const Drawing d = drawn([](Panel& panel) {
    panel.x.min = panel.y.min = 0.0;
    panel.x.max = 4.0;
    panel.y.max = 1.0;
    panel.line("", Values{0, 4}, Values{0, 1});
  });
  for (const double value : {0.0, 1.0, 2.0, 3.0, 4.0}) {
    const double x = d.left() + value / 4.0 * d.width();
    const Element number = [&] {
      for (const Element& e : d.all("text")) {
        if (e.content() == number_text(value, 1) && e.get("text-anchor") == "middle") return e;
      }
      return Element{};
    }();
    EXPECT_NEAR(number.num("x"), x, 0.11);
    expect_near(number.num("y") - d.bottom(), 17.0, 0.25);
    int ticks = 0, grid = 0;
    for (const Element& e : d.all("path")) {
      const auto p = e.points();
      if (std::abs(p[0].x - x) > 0.11 || std::abs(p[1].x - x) > 0.11) continue;
      if (e.has("#222")) {
        EXPECT_EQ(p[0].y, d.bottom());
        expect_near(p[1].y - p[0].y, 4.5, 0.3);
        ++ticks;
      } else {
        EXPECT_EQ(p[0].y, d.top());
        EXPECT_EQ(p[1].y, d.bottom());
        ++grid;
      }
    }
    EXPECT_EQ(ticks, 1) << value;
    EXPECT_EQ(grid, 1) << value;
  }
  for (const double value : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) {
    const double y = d.bottom() - value * d.height();
    const Element number = [&] {
      for (const Element& e : d.all("text")) {
        if (e.content() == number_text(value, 1) && e.get("text-anchor") == "end") return e;
      }
      return Element{};
    }();
    expect_near(d.left() - number.num("x"), 7.0, 0.3);
    expect_near(number.num("y") - y, 4.0, 0.3);  // a third of its size: centered
    int ticks = 0, grid = 0;
    for (const Element& e : d.all("path")) {
      const auto p = e.points();
      if (std::abs(p[0].y - y) > 0.11 || std::abs(p[1].y - y) > 0.11) continue;
      if (e.has("#222")) {
        expect_near(d.left() - p[0].x, 4.5, 0.3);
        EXPECT_EQ(p[1].x, d.left());
        ++ticks;
      } else {
        EXPECT_EQ(p[0].x, d.left());
        EXPECT_NEAR(p[1].x, d.right(), 0.11);
        ++grid;
      }
    }
    EXPECT_EQ(ticks, 1) << value;
    EXPECT_EQ(grid, 1) << value;
  }
}

TEST(PlotFrame, MinorTicksOfDecadesAreShorterAndFainter) {
  const Drawing d = drawn([](Panel& panel) {
    panel.x.log = panel.y.log = true;
    panel.y.min = 1.0;
    panel.y.max = 1000.0;
    panel.line("", Values{1, 1000}, Values{1, 1000});
  });
  int minor_x = 0, minor_y = 0;
  for (const Element& e : d.all("path", "stroke=\"#222\"")) {
    const auto p = e.points();
    const double length = std::hypot(p[1].x - p[0].x, p[1].y - p[0].y);
    if (length > 4.0) continue;
    expect_near(length, 2.5, 0.3);
    (p[0].x == p[1].x ? minor_x : minor_y) += 1;
  }
  EXPECT_EQ(minor_x, 24);  // eight between each two of four decades
  EXPECT_EQ(minor_y, 24);
  EXPECT_EQ(d.all("path", "#f1f1f1").size(), 48U);
  EXPECT_EQ(d.all("path", "#dedede").size(), 8U);
}

TEST(PlotFrame, OneTickHasFiftyFivePixelsUpAndSeventyFiveAcross) {
  for (const double size : {150.0, 300.0, 600.0, 900.0}) {
    const Drawing d = drawn(
        [](Panel& panel) {
          panel.x.min = panel.y.min = 0.0;
          panel.x.max = panel.y.max = 1.0;
          panel.line("", Values{0, 1}, Values{0, 1});
        },
        size, size);
    std::size_t up = 0, across = 0;
    for (const Element& e : d.all("text")) (e.get("text-anchor") == "end" ? up : across) += 1;
    EXPECT_EQ(up, linear_ticks(0, 1, std::max(2, static_cast<int>(size / 55.0))).size()) << size;
    EXPECT_EQ(across, linear_ticks(0, 1, std::max(2, static_cast<int>(d.width() / 75.0))).size()) << size;
  }
}

// ---- What of the data it shows.

/// Ends of both axes in data, from where two known values lie.
struct Ends {
  double x_low, x_high, y_low, y_high;
};
Ends ends_of(const Drawing& d, const std::vector<PointPx>& px, const Values& x, const Values& y) {
  const PointPx a = d.in_frame(px.front()), b = d.in_frame(px.back());
  const double sx = (x.back() - x.front()) / (b.x - a.x), sy = (y.back() - y.front()) / (b.y - a.y);
  return {x.front() - sx * a.x, x.front() + sx * (1.0 - a.x), y.front() - sy * a.y, y.front() + sy * (1.0 - a.y)};
}

TEST(PlotRange, OfALineIsTightAlongXAndHasATwentiethOfRoomAlongY) {
  const auto ends = [](const Values& y) {
    const Values x{3, 7};
    const Drawing d = drawn([&](Panel& panel) { panel.line("", x, y); });
    return ends_of(d, d.all("polyline")[0].points(), x, y);
  };
  const Ends plain = ends({10, 20});
  EXPECT_NEAR(plain.x_low, 3.0, 0.01);
  EXPECT_NEAR(plain.x_high, 7.0, 0.01);
  EXPECT_NEAR(plain.y_low, 9.5, 0.03);
  EXPECT_NEAR(plain.y_high, 20.5, 0.03);
  // Much of the way to zero: then zero, without room below it.
  EXPECT_NEAR(ends({6.9, 20}).y_low, 0.0, 0.05);
  EXPECT_NEAR(ends({7.1, 20}).y_low, 7.1 - 0.05 * 12.9, 0.05);
  EXPECT_NEAR(ends({6.9, 20}).y_high, 21.0, 0.05);
  EXPECT_NEAR(ends({-1, 20}).y_low, -2.05, 0.05);
  EXPECT_NEAR(ends({-8, 0}).y_high, 0.0, 0.02);
  EXPECT_NEAR(ends({-8, 0}).y_low, -8.4, 0.02);
}

TEST(PlotRange, OfMarkersHasRoomAlongXAsWell) {
  const Values x{3, 7}, y{10, 20};
  for (const bool scatter : {true, false}) {
    const Drawing d = drawn(
        [&](Panel& panel) { scatter ? panel.scatter("", x, y) : panel.line("", x, y, {.marker = Marker::kCircle}); });
    const auto circles = d.all("circle");
    ASSERT_EQ(circles.size(), 2U);
    const Ends ends =
        ends_of(d, {{circles[0].num("cx"), circles[0].num("cy")}, {circles[1].num("cx"), circles[1].num("cy")}}, x, y);
    EXPECT_NEAR(ends.x_low, 2.8, 0.01);
    EXPECT_NEAR(ends.x_high, 7.2, 0.01);
  }
}

TEST(PlotRange, OfOneValueIsATenthOfItOrAHalfToBothSides) {
  for (const auto& [value, half] : {std::pair(50.0, 5.0), {-50.0, 5.0}, {2.0, 0.5}, {0.0, 0.5}}) {
    const Drawing d = drawn([&, v = value](Panel& panel) {
      panel.line("", Values{0, 1}, Values{v, v});
      panel.horizontal("", v * (1.0 + 1e-12));  // the same but for its last bits
    });
    EXPECT_NEAR(shares_of(d)[0].y, 0.5, 2 * kShare);
    // Numbers at the ticks tell how far it reaches: some lie beyond half of it.
    double most = 0.0;
    for (const Element& e : d.all("text")) {
      if (e.get("text-anchor") == "end") most = std::max(most, std::abs(std::stod(e.content()) - value));
    }
    EXPECT_LE(most, half + 1e-9) << value;
    EXPECT_GT(most, 0.55 * half) << value;
  }
}

TEST(PlotRange, OfDecadesHasAFewHundredthsOfRoomAndOfOneValueAFactorOfTwo) {
  const auto share = [](const Values& y) {
    const Drawing d = drawn([&](Panel& panel) {
      panel.y.log = true;
      Values x;
      for (std::size_t i = 0; i < y.size(); ++i) x.push_back(static_cast<double>(i));
      panel.line("", x, y);
    });
    return shares_of(d);
  };
  const double room = 0.04 / 1.08;
  EXPECT_NEAR(share({1, 1000})[0].y, room, kShare);
  EXPECT_NEAR(share({1, 1000})[1].y, 1.0 - room, kShare);
  EXPECT_NEAR(share({5, 5})[0].y, 0.5, kShare);
  // Zeros and what lies below them do not count.
  const auto broken = share({-3, 10, 1000, 0, 100});
  ASSERT_EQ(broken.size(), 2U);
  EXPECT_NEAR(broken[0].y, room, kShare);
  // A factor of four around one value.
  const Drawing d = drawn([&](Panel& panel) {
    panel.y.log = true;
    panel.line("", Values{0, 1}, Values{5, 5});
    panel.y.max = 10.0;
    panel.y.min = 2.5;
  });
  const Drawing own = drawn([&](Panel& panel) {
    panel.y.log = true;
    panel.line("", Values{0, 1}, Values{5, 5});
  });
  EXPECT_NEAR(shares_of(d)[0].y, 0.5, kShare);
  EXPECT_NEAR(own.top() + own.bottom() - 2.0 * own.all("polyline")[0].points()[0].y, 0.0, 0.5);
  // Tight along x.
  const Drawing across = drawn([](Panel& panel) {
    panel.x.log = true;
    panel.line("", Values{1, 10, 100}, Values{0, 1, 2});
  });
  EXPECT_NEAR(shares_of(across)[0].x, 0.0, kShare);
  EXPECT_NEAR(shares_of(across)[1].x, 0.5, kShare);
  EXPECT_NEAR(shares_of(across)[2].x, 1.0, kShare);
}

TEST(PlotRange, LimitsThatMakeNoSenseStillMakeAPicture) {
  const auto line = [](std::optional<double> low, std::optional<double> high, bool log) {
    const Drawing d = drawn([&](Panel& panel) {
      panel.y.min = low;
      panel.y.max = high;
      panel.y.log = log;
      panel.line("", Values{0, 1}, Values{4.0, 8.0});
    });
    return shares_of(d);
  };
  // The upper end does not lie above the lower one: it is one more, or ten times as much.
  EXPECT_NEAR(line(4.0, 4.0, false)[0].y, 0.0, kShare);
  EXPECT_NEAR(line(4.0, 3.0, false)[1].y, 4.0, 20 * kShare);
  EXPECT_NEAR(line(4.0, 4.0, true)[1].y, std::log10(2.0), kShare);
  // Decades from zero on begin at a thousandth.
  EXPECT_NEAR(line(0.0, 8.0, true)[0].y, 1.0 - std::log10(2.0) / 3.0, kShare);
  EXPECT_NEAR(line(-1.0, -1.0, true)[0].y, std::log10(4.0 / 1e-3), 20 * kShare) << "0.001 to 0.01";
  // Of nothing an axis goes from 0 to 1, or from 0.1 on.
  const Drawing none = drawn([](Panel&) {});
  EXPECT_FALSE(none.text("0").line.empty());
  EXPECT_FALSE(none.text("1").line.empty());
  EXPECT_TRUE(none.text("1.2").line.empty());
  const Drawing decades = drawn([](Panel& panel) { panel.y.log = true; });
  EXPECT_FALSE(decades.text("0.1").line.empty());
}

TEST(PlotRange, FarOutsideIsAHundredFramesAway) {
  const Drawing d = drawn([](Panel& panel) {
    panel.x.min = panel.y.min = 0.0;
    panel.x.max = panel.y.max = 1.0;
    panel.line("", Values{0, 0.5, 1}, Values{-1e9, 60.0, 1e9});
  });
  const auto shares = shares_of(d);
  EXPECT_NEAR(shares[0].y, -100.0, 0.01);
  EXPECT_NEAR(shares[1].y, 60.0, 0.01);
  EXPECT_NEAR(shares[2].y, 100.0, 0.01);
}

TEST(PlotRange, CountsEveryKindOfMark) {
  const auto y_of = [](const auto& fill, double value) {  // where a value lies, as a share
    const Drawing d = drawn([&](Panel& panel) {
      fill(panel);
      panel.horizontal("", value, {.color = 5});
    });
    for (const Element& e : d.all("path", "#56B4E9")) return d.in_frame(e.points()[0]).y;
    return std::nan("");
  };
  const double top = 1.05 / 1.1;  // of what lies highest
  EXPECT_NEAR(y_of([](Panel& p) { p.line("", Values{0, 1}, Values{10, 20}); }, 20.0), top, kShare);
  EXPECT_NEAR(y_of([](Panel& p) { p.band("", Values{0, 1}, Values{10, 11}, Values{12, 20}); }, 20.0), top, kShare);
  EXPECT_NEAR(y_of(
                  [](Panel& p) {
                    p.band("", Values{0, 1}, Values{10, 11}, Values{12, 20});
                  },
                  10.0),
              1.0 - top, kShare);
  EXPECT_NEAR(y_of([](Panel& p) { p.text(0.5, 20.0, "a").text(0.5, 10.0, "b"); }, 20.0), top, kShare);
  Box box{.low = 10, .q1 = 12, .median = 13, .q3 = 14, .high = 15, .mean = 13, .outliers = {20}};
  EXPECT_NEAR(y_of([&](Panel& p) { p.boxes("", {box}); }, 20.0), top, kShare);
  EXPECT_NEAR(y_of([&](Panel& p) { p.boxes("", {box}); }, 10.0), 1.0 - top, kShare);
  box = {.low = 12, .q1 = 12, .median = 13, .q3 = 14, .high = 15, .mean = 20, .outliers = {}};
  EXPECT_NEAR(y_of([&](Panel& p) { p.boxes("", {box}); }, 20.0), (20.0 - 12.0 + 0.4) / 8.8, kShare);
  // A vertical does not count along y, a horizontal not along x.
  EXPECT_NEAR(y_of([](Panel& p) { p.line("", Values{0, 1}, Values{10, 20}).vertical("", 900.0); }, 20.0), top, kShare);
  const Drawing d = drawn([](Panel& p) { p.line("", Values{3, 7}, Values{10, 20}).horizontal("", 15.0); });
  EXPECT_NEAR(shares_of(d)[1].x, 1.0, kShare);
  const Drawing reaching = drawn([](Panel& p) { p.line("", Values{3, 7}, Values{10, 20}).vertical("", 11.0); });
  EXPECT_NEAR(shares_of(reaching)[1].x, 0.5, kShare);
}

// ---- Marks.

TEST(PlotMarks, HaveTheirShapeAroundTheirPoint) {
  const auto mark = [](Marker marker, double r) {
    return drawn([&](Panel& panel) {
      panel.x.min = panel.y.min = 0.0;
      panel.x.max = panel.y.max = 2.0;
      panel.scatter("", Values{1}, Values{1}, {.marker = marker, .marker_px = r});
    });
  };
  const auto middle_of = [](const Drawing& d) {
    return PointPx{0.5 * (d.left() + d.right()), 0.5 * (d.top() + d.bottom())};
  };
  const double r = 10.0;
  const Drawing circle = mark(Marker::kCircle, r);
  ASSERT_EQ(circle.all("circle").size(), 1U);
  EXPECT_NEAR(circle.all("circle")[0].num("cx"), middle_of(circle).x, 0.11);
  EXPECT_NEAR(circle.all("circle")[0].num("cy"), middle_of(circle).y, 0.11);
  EXPECT_EQ(circle.all("circle")[0].num("r"), r);
  const Drawing square = mark(Marker::kSquare, r);
  const Element rect = square.all("rect", "#0072B2").at(0);
  EXPECT_NEAR(rect.num("x"), middle_of(square).x - r, 0.11);
  EXPECT_NEAR(rect.num("y"), middle_of(square).y - r, 0.11);
  EXPECT_EQ(rect.num("width"), 2 * r);
  EXPECT_EQ(rect.num("height"), 2 * r);
  // A diamond and a triangle are about as large as the circle.
  for (const Marker marker : {Marker::kDiamond, Marker::kTriangle}) {
    const Drawing d = mark(marker, r);
    const PointPx m = middle_of(d);
    const auto p = d.all("polygon").at(0).points();
    double area = 0.0, left = 0.0, right = 0.0, up = 0.0, down = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const PointPx &a = p[i], &b = p[(i + 1) % p.size()];
      area += 0.5 * (a.x * b.y - b.x * a.y);
      left = std::max(left, m.x - a.x), right = std::max(right, a.x - m.x);
      up = std::max(up, m.y - a.y), down = std::max(down, a.y - m.y);
    }
    EXPECT_EQ(p.size(), marker == Marker::kDiamond ? 4U : 3U);
    EXPECT_NEAR(left, right, 0.11);
    EXPECT_NEAR(left, marker == Marker::kDiamond ? 13.0 : 11.0, 1.2);
    EXPECT_NEAR(up, marker == Marker::kDiamond ? 13.0 : 12.0, 1.2);
    EXPECT_NEAR(down, marker == Marker::kDiamond ? 13.0 : 8.0, 1.2);
    EXPECT_NEAR(std::abs(area), marker == Marker::kDiamond ? 338.0 : 220.0, 40.0);
  }
  const Drawing cross = mark(Marker::kCross, r);
  const auto strokes = cross.all("path", "#0072B2");
  ASSERT_EQ(strokes.size(), 2U);
  for (const Element& e : strokes) {
    const auto p = e.points();
    EXPECT_NEAR(std::abs(p[1].x - p[0].x), 2 * r, 0.11);
    EXPECT_NEAR(std::abs(p[1].y - p[0].y), 2 * r, 0.11);
    EXPECT_NEAR(0.5 * (p[0].x + p[1].x), middle_of(cross).x, 0.11);
    EXPECT_FALSE(e.has("dasharray"));
  }
  const auto a = strokes[0].points(), b = strokes[1].points();
  EXPECT_LT((a[1].y - a[0].y) * (a[1].x - a[0].x) * (b[1].y - b[0].y) * (b[1].x - b[0].x), 0.0) << "they cross";
}

TEST(PlotMarks, BarsStandSideBySideOnZeroOrOnTheFrame) {
  for (const std::size_t count : {1U, 2U, 3U}) {
    const Drawing d = drawn([&](Panel& panel) {
      panel.x.min = -1.0;
      panel.x.max = 2.0;
      panel.y.min = -2.0;
      panel.y.max = 6.0;
      for (std::size_t i = 0; i < count; ++i) panel.bars("", Values{4.0, -1.0}, {.color = static_cast<int>(i)});
    });
    const double unit = d.width() / 3.0, up = d.height() / 8.0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto bars = d.all("rect", palette()[i]);
      ASSERT_EQ(bars.size(), 2U);
      const double slot = 0.8 / static_cast<double>(count);
      for (int k = 0; k < 2; ++k) {
        const double center = k + (static_cast<double>(i) - 0.5 * (static_cast<double>(count) - 1)) * slot;
        EXPECT_NEAR(bars[k].num("x") + 0.5 * bars[k].num("width"), d.left() + unit * (1.0 + center), 0.11);
        EXPECT_NEAR(bars[k].num("width"), 0.92 * slot * unit, 0.11);
        EXPECT_NEAR(bars[k].num("y"), d.bottom() - up * (k == 0 ? 6.0 : 2.0), 0.11);
        EXPECT_NEAR(bars[k].num("height"), up * (k == 0 ? 4.0 : 1.0), 0.11);
        EXPECT_NEAR(bars[k].num("fill-opacity"), 0.85, 0.15);
        EXPECT_LE(bars[k].num("fill-opacity"), 1.0);
      }
    }
  }
  const Drawing log = drawn([](Panel& panel) {
    panel.y.log = true;
    panel.y.min = 1.0;
    panel.y.max = 100.0;
    panel.bars("", Values{10.0, 0.0, std::nan("")});
  });
  const auto bars = log.all("rect", "#0072B2");
  ASSERT_EQ(bars.size(), 1U) << "zero has no logarithm";
  EXPECT_NEAR(bars[0].num("height"), 0.5 * log.height(), 0.11);
  EXPECT_NEAR(bars[0].num("y") + bars[0].num("height"), log.bottom(), 0.11);
  // Alone, three bars reach from 0.6 before the first to 0.6 behind the last, and up from zero.
  const Drawing own = drawn([](Panel& panel) { panel.bars("", Values{3, 2, 4}); });
  const auto three = own.all("rect", "#0072B2");
  ASSERT_EQ(three.size(), 3U);
  EXPECT_NEAR(three[0].num("x") + 0.5 * three[0].num("width"), own.left() + own.width() * 0.6 / 3.2, 0.15);
  EXPECT_NEAR(three[2].num("x") + 0.5 * three[2].num("width"), own.left() + own.width() * 2.6 / 3.2, 0.15);
  EXPECT_NEAR(three[2].num("height"), own.height() * 4.0 / 4.2, 0.15);
  const Drawing high = drawn([](Panel& panel) { panel.bars("", Values{90, 100}); });
  EXPECT_NEAR(high.all("rect", "#0072B2")[0].num("height"), high.height() * 90.0 / 105.0, 0.15);
}

TEST(PlotMarks, BoxesShowQuartilesWhiskersTheMeanAndOutliers) {
  const Box box{.low = 1, .q1 = 3, .median = 4, .q3 = 6, .high = 8, .mean = 4.5, .outliers = {9, 9.5}};
  const Drawing d = drawn([&](Panel& panel) {
    panel.x.min = -1.0;
    panel.x.max = 1.0;
    panel.y.min = 0.0;
    panel.y.max = 10.0;
    panel.boxes("", {box});
  });
  const double unit = 0.5 * d.width(), up = 0.1 * d.height(), middle = d.left() + unit;
  const double half = 0.36 * 0.8 * unit;
  const auto y = [&](double value) { return d.bottom() - up * value; };
  const Element rect = d.all("rect", "#0072B2").at(0);
  EXPECT_NEAR(rect.num("x"), middle - half, 0.11);
  EXPECT_NEAR(rect.num("width"), 2 * half, 0.11);
  EXPECT_NEAR(rect.num("y"), y(6), 0.11);
  EXPECT_NEAR(rect.num("height"), 3 * up, 0.11);
  EXPECT_NEAR(rect.num("fill-opacity"), 0.3, 0.12);
  EXPECT_NEAR(rect.num("stroke-width"), 1.2, 0.4);
  const auto lines = d.all("path", "#0072B2");
  ASSERT_EQ(lines.size(), 5U);
  const auto expect_line = [&](const Element& e, double x0, double y0, double x1, double y1) {
    const auto p = e.points();
    EXPECT_NEAR(p[0].x, x0, 0.11);
    EXPECT_NEAR(p[0].y, y0, 0.11);
    EXPECT_NEAR(p[1].x, x1, 0.11);
    EXPECT_NEAR(p[1].y, y1, 0.11);
  };
  expect_line(lines[0], middle, y(1), middle, y(3));
  expect_line(lines[1], middle, y(6), middle, y(8));
  expect_line(lines[2], middle - 0.5 * half, y(1), middle + 0.5 * half, y(1));
  expect_line(lines[3], middle - 0.5 * half, y(8), middle + 0.5 * half, y(8));
  expect_line(lines[4], middle - half, y(4), middle + half, y(4));
  EXPECT_GT(lines[4].num("stroke-width"), 1.5 * lines[0].num("stroke-width")) << "the median is what one looks for";
  EXPECT_LT(lines[4].num("stroke-width"), 2.6 * lines[0].num("stroke-width"));
  const auto mean = d.all("polygon").at(0).points();
  EXPECT_NEAR(0.5 * (mean[0].y + mean[2].y), y(4.5), 0.11);
  EXPECT_NEAR(mean[1].x - mean[3].x, 6.5, 1.5);
  const auto outliers = d.all("circle");
  ASSERT_EQ(outliers.size(), 2U);
  EXPECT_NEAR(outliers[0].num("cy"), y(9), 0.11);
  EXPECT_NEAR(outliers[0].num("cx"), middle, 0.11);
  EXPECT_NEAR(outliers[0].num("r"), 1.5, 0.6);
  EXPECT_NEAR(outliers[0].num("fill-opacity"), 0.5, 0.2);
}

TEST(PlotMarks, BandsLieBetweenTheirLinesAndBreakWhereAValueIsMissing) {
  const double nan = std::nan("");
  const Drawing d = drawn([&](Panel& panel) {
    panel.x.min = panel.y.min = 0.0;
    panel.x.max = panel.y.max = 4.0;
    panel.band("", Values{0, 1, 2, 3, 4}, Values{1, 0, nan, 1, 1}, Values{2, 3, 4, 2, 3});
  });
  const auto bands = d.all("polygon");
  ASSERT_EQ(bands.size(), 2U);
  const std::vector<PointPx> first = bands[0].points(), second = bands[1].points();
  const double expected[][2] = {{0, 1}, {1, 0}, {1, 3}, {0, 2}};
  ASSERT_EQ(first.size(), 4U);
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(d.in_frame(first[i]).x, expected[i][0] / 4.0, kShare);
    EXPECT_NEAR(d.in_frame(first[i]).y, expected[i][1] / 4.0, kShare);
  }
  EXPECT_EQ(second.size(), 4U);
  EXPECT_NEAR(bands[0].num("fill-opacity"), 0.22, 0.09) << "what lies behind shines through";
}

TEST(PlotMarks, LinesTakeTheirStyle) {
  const auto stroke_of = [](const Style& style) {
    return drawn([&](Panel& panel) { panel.line("", Values{0, 1}, Values{0, 1}, style); }).all("polyline").at(0);
  };
  EXPECT_EQ(stroke_of({.width_px = 2.25}).get("stroke-width"), "2.25");
  EXPECT_EQ(stroke_of({}).get("stroke-opacity"), "");
  EXPECT_EQ(stroke_of({.opacity = 0.5}).get("stroke-opacity"), "0.5");
  EXPECT_EQ(stroke_of({}).get("stroke-dasharray"), "");
  EXPECT_NE(stroke_of({.dash = Dash::kDashed}).get("stroke-dasharray"), "");
  EXPECT_NE(stroke_of({.dash = Dash::kDotted}).get("stroke-dasharray"),
            stroke_of({.dash = Dash::kDashed}).get("stroke-dasharray"));
  EXPECT_EQ(stroke_of({.color = 0}).get("stroke"), palette()[0]);
  EXPECT_EQ(stroke_of({.color = 8}).get("stroke"), palette()[1]);
  const Drawing d = drawn([](Panel& panel) {
    for (int i = 0; i < 3; ++i) panel.line("", Values{0, 1}, Values{0, 1});
    panel.line("", Values{0, 1}, Values{0, 1}, {.color = 5});
    panel.line("", Values{0, 1}, Values{0, 1});
  });
  const auto lines = d.all("polyline");
  for (const auto& [line, color] : {std::pair(0, 0), {1, 1}, {2, 2}, {3, 5}, {4, 3}})
    EXPECT_EQ(lines.at(static_cast<std::size_t>(line)).get("stroke"), palette()[static_cast<std::size_t>(color)]);
}

TEST(PlotMarks, StepsHoldTheirValueUntilTheNext) {
  const Drawing d = drawn([](Panel& panel) {
    panel.x.min = panel.y.min = 0.0;
    panel.x.max = panel.y.max = 4.0;
    panel.step("", Values{0, 2, 4}, Values{1, 3, 2});
  });
  const double expected[][2] = {{0, 1}, {2, 1}, {2, 3}, {4, 3}, {4, 2}};
  const auto shares = shares_of(d);
  ASSERT_EQ(shares.size(), 5U);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(4.0 * shares[i].x, expected[i][0], 0.01);
    EXPECT_NEAR(4.0 * shares[i].y, expected[i][1], 0.01);
  }
}

TEST(PlotMarks, StraightLinesCrossTheFrameAndWordsStandAtTheirPlace) {
  const Drawing d = drawn([](Panel& panel) {
    panel.x.min = panel.y.min = 0.0;
    panel.x.max = panel.y.max = 4.0;
    panel.horizontal("", 1.0, {.color = 1}).vertical("", 3.0, {.color = 2}).text(2.0, 2.0, "here");
  });
  const auto h = d.all("path", "#D55E00").at(0).points(), v = d.all("path", "#009E73").at(0).points();
  EXPECT_EQ(h[0].x, d.left());
  EXPECT_NEAR(h[1].x, d.right(), 0.11);
  EXPECT_NEAR(d.in_frame(h[0]).y, 0.25, kShare);
  EXPECT_EQ(v[0].y, d.top());
  EXPECT_NEAR(v[1].y, d.bottom(), 0.11);
  EXPECT_NEAR(d.in_frame(v[0]).x, 0.75, kShare);
  const Element words = d.text("here");
  EXPECT_NEAR(words.num("x"), 0.5 * (d.left() + d.right()), 0.11);
  EXPECT_NEAR(words.num("y"), 0.5 * (d.top() + d.bottom()), 0.11);
  EXPECT_EQ(words.get("text-anchor"), "");
  EXPECT_NEAR(words.num("font-size"), 11.0, 2.0);
}

// ---- The legend.

struct LegendPlace {
  double left, top, width, height;
  bool framed;
};

LegendPlace legend_of(const Drawing& d) {
  const auto frames = d.all("rect", "stroke=\"#ccc\"");
  if (frames.empty()) return {0, 0, 0, 0, false};
  return {frames[0].num("x"), frames[0].num("y"), frames[0].num("width"), frames[0].num("height"), true};
}

TEST(PlotLegend, TakesTheFirstCornerThatNoMarkComesNear) {
  const double six = 6.0;
  // What is covered: any of the four corners.
  for (int corners = 0; corners < 16; ++corners) {
    const Drawing d = drawn(
        [&](Panel& panel) {
          panel.x.min = panel.y.min = 0.0;
          panel.x.max = panel.y.max = 1.0;
          panel.line("a name", Values{0.5, 0.5}, Values{0.4, 0.6});
          const double at[][2] = {{0.97, 0.97}, {0.03, 0.97}, {0.97, 0.03}, {0.03, 0.03}};
          for (int c = 0; c < 4; ++c) {
            if (corners >> c & 1) panel.scatter("", Values{at[c][0]}, Values{at[c][1]});
          }
        },
        500, 400);
    const LegendPlace legend = legend_of(d);
    int first = 0;
    while (first < 4 && corners >> first & 1) ++first;
    EXPECT_EQ(legend.framed, first < 4) << corners;
    if (!legend.framed) continue;
    EXPECT_NEAR(legend.width, 6.0 * 0.6 * 11.0 + 42.0, 4.0);
    EXPECT_NEAR(legend.height, 25.0, 3.0);
    EXPECT_NEAR(first % 2 == 0 ? d.right() - legend.left - legend.width : legend.left - d.left(), six, 1.5) << corners;
    EXPECT_NEAR(first < 2 ? legend.top - d.top() : d.bottom() - legend.top - legend.height, six, 1.5) << corners;
  }
}

// Each kind of mark, five pixels beside the legend's place and a little nearer.
TEST(PlotLegend, KeepsFivePixelsFromEveryKindOfMark) {
  const auto is_right = [](const auto& add) {
    const Drawing d = drawn(
        [&](Panel& panel) {
          panel.x.min = panel.y.min = 0.0;
          panel.x.max = panel.y.max = 1.0;
          panel.vertical("a name", 0.5);
          add(panel);
        },
        500, 400);
    const LegendPlace legend = legend_of(d);
    return legend.framed && legend.left > d.left() + 0.5 * d.width();
  };
  const Drawing d = drawn(
      [](Panel& panel) {
        panel.x.min = panel.y.min = 0.0;
        panel.x.max = panel.y.max = 1.0;
        panel.vertical("a name", 0.5);
      },
      500, 400);
  const LegendPlace legend = legend_of(d);
  ASSERT_TRUE(legend.framed);
  const double left = (legend.left - d.left()) / d.width(),
               bottom = (d.bottom() - legend.top - legend.height) / d.height();
  const double x_px = 1.0 / d.width(), y_px = 1.0 / d.height();
  for (const double nearer_px : {-1.3, 1.3}) {
    const bool is_free = nearer_px < 0.0;
    const double x = left + (nearer_px - 5.0) * x_px, y = bottom + (nearer_px - 5.0) * y_px;
    const double high = bottom + 20.0 * y_px, far = left + 20.0 * x_px;  // within it, the other way
    EXPECT_EQ(is_right([&](Panel& p) { p.scatter("", Values{x}, Values{high}); }), is_free);
    EXPECT_EQ(is_right([&](Panel& p) { p.scatter("", Values{far}, Values{y}); }), is_free);
    EXPECT_EQ(is_right([&](Panel& p) { p.text(x, high, "word"); }), is_free);
    EXPECT_EQ(is_right([&](Panel& p) { p.line("", Values{x, x}, Values{0.0, 1.0}); }), is_free);
    EXPECT_EQ(is_right([&](Panel& p) { p.line("", Values{0.6, 1.0}, Values{y, y}); }), is_free);
    EXPECT_EQ(is_right([&](Panel& p) { p.vertical("", x); }), is_free);
    EXPECT_EQ(is_right([&](Panel& p) { p.band("", Values{0.6, x}, Values{0.5, 0.0}, Values{0.6, 1.0}); }), is_free);
    EXPECT_EQ(is_right([&](Panel& p) { p.band("", Values{far, 1.0}, Values{0.0, 0.0}, Values{y, y}); }), is_free);
  }
  // A horizontal reaches into both upper corners: the lower right one is next.
  EXPECT_TRUE(is_right([&](Panel& p) { p.horizontal("", bottom + 10.0 * y_px); }));
}

TEST(PlotLegend, StandsBesideTheFrameWhereItIsToldToOrTooLarge) {
  const std::string long_name(40, 'm');
  for (const int reason : {0, 1, 2}) {  // told to; too wide; too high
    const auto fill = [&](bool named) {
      return drawn(
          [&](Panel& panel) {
            panel.legend = reason == 0 ? Legend::kOutside : Legend::kAuto;
            if (!named) panel.legend = Legend::kNone;
            const int count = reason == 2 ? 11 : 2;
            for (int i = 0; i < count; ++i)
              panel.line(reason == 1 ? long_name : "name " + std::to_string(i), Values{0, 0.01}, Values{0, 0.01});
            panel.x.max = panel.y.max = 1.0;
          },
          500, 300);
    };
    const Drawing d = fill(true), bare = fill(false);
    EXPECT_TRUE(d.all("rect", "stroke=\"#ccc\"").empty());
    const std::string name = reason == 1 ? long_name : "name 0";
    const double width = 0.6 * 11.0 * static_cast<double>(name.size() + (reason == 2 ? 1 : 0)) + 26.0 + 16.0;
    EXPECT_NEAR(bare.right() - d.right(), width + 4.0, 8.0) << reason;
    const Element first = d.text(name);
    EXPECT_NEAR(first.num("x") - d.right(), 10.0 + 26.0 + 8.0, 8.0);
    EXPECT_LT(first.num("x") + 0.6 * 11.0 * static_cast<double>(name.size()), 500.0) << "in the picture";
    EXPECT_NEAR(first.num("y") - d.top(), 4.0 + 8.5 + 4.0, 3.0);
    EXPECT_TRUE(bare.text(name).line.empty());
  }
  // Six tenths of the frame are just small enough: nine rows of 17 and 8 pixels in 161 of 268.
  for (const auto& [rows, framed] : {std::pair(8, true), {9, false}}) {
    const Drawing d = drawn(
        [rows = rows](Panel& panel) {
          for (int i = 0; i < rows; ++i) panel.vertical("name", 0.0);
          panel.x.max = 1.0;
        },
        700, 290);
    EXPECT_EQ(legend_of(d).framed, framed) << d.height();
  }
}

TEST(PlotLegend, RowsHaveASwatchOfTheirMarkAndTheirName) {
  const Drawing d = drawn(
      [](Panel& panel) {
        panel.legend = Legend::kOutside;
        panel.line("line", Values{0, 1}, Values{0, 1}, {.marker = Marker::kCircle});
        panel.scatter("points", Values{0, 1}, Values{0, 1});
        panel.band("band", Values{0, 1}, Values{0, 1}, Values{1, 2});
        panel.bars("bars", Values{1});
        panel.boxes("boxes", {Box{0, 1, 2, 3, 4, 2, {}}});
        panel.text(0, 0, "no row").line("", Values{0, 1}, Values{0, 1});
      },
      600, 400);
  const char* names[] = {"line", "points", "band", "bars", "boxes"};
  const double swatch_left = d.right() + 10.0 + 4.0 + 3.0;
  for (int i = 0; i < 5; ++i) {
    const Element name = d.text(names[i]);
    const double middle = d.top() + 4.0 + 17.0 * (i + 0.5);
    EXPECT_NEAR(name.num("y") - 4.0, middle, 2.5) << names[i];
    EXPECT_NEAR(name.num("font-size"), 11.0, 2.0);
    if (i > 0) {
      EXPECT_NEAR(name.num("y") - d.text(names[i - 1]).num("y"), 17.0, 2.5);
    }
    int lines = 0, circles = 0, rects = 0;
    for (const Element& e : d.elements) {
      if (e.is("path") && e.points()[0].x > d.right() && std::abs(e.points()[0].y - middle) < 4.0) {
        ++lines;
        EXPECT_NEAR(e.points()[0].x, swatch_left, 3.0);
        EXPECT_NEAR(e.points()[1].x - e.points()[0].x, 20.0, 4.0);
      }
      if (e.is("circle") && e.num("cx") > d.right() && std::abs(e.num("cy") - middle) < 4.0) {
        ++circles;
        EXPECT_NEAR(e.num("cx"), swatch_left + 10.0, 3.0);
      }
      if (e.is("rect") && e.num("x") > d.right() && std::abs(e.num("y") + 0.5 * e.num("height") - middle) < 4.0) {
        ++rects;
        EXPECT_NEAR(e.num("width"), 20.0, 4.0);
        EXPECT_NEAR(e.num("height"), 10.0, 2.5);
        EXPECT_NEAR(e.num("fill-opacity"), i == 3 ? 0.85 : 0.3, i == 3 ? 0.15 : 0.12);
        EXPECT_EQ(e.has("stroke-width"), i == 4);
      }
    }
    EXPECT_EQ(lines, i == 0 ? 1 : 0) << names[i];
    EXPECT_EQ(circles, i < 2 ? 1 : 0) << names[i];
    EXPECT_EQ(rects, i >= 2 ? 1 : 0) << names[i];
  }
  EXPECT_TRUE(d.all("text").size() >= 5U);
}

TEST(PlotLegend, KeepsAwayFromBarsAndBoxesAtTheirFullWidth) {
  // One bar or box in the right half that reaches up to the legend: the left corner is free.
  for (const bool log : {false, true}) {
    for (const double height : {0.3, 0.98}) {
      const Drawing d = drawn(
          [&](Panel& panel) {
            panel.x.min = -0.6;
            panel.x.max = 1.6;
            panel.y.min = log ? 0.01 : 0.0;
            panel.y.max = 1.0;
            panel.y.log = log;
            panel.bars("a name", Values{0.01, height});
          },
          500, 400);
      const LegendPlace legend = legend_of(d);
      ASSERT_TRUE(legend.framed);
      EXPECT_EQ(legend.left > d.left() + 0.5 * d.width(), height < 0.5) << log << height;
    }
  }
}

// ---- Other shapes of the frame.

TEST(PlotFrame, NamesThatDoNotFitSideBySideAreSlanted) {
  const auto with = [](const std::string& name) {
    return drawn(
        [&](Panel& panel) {
          panel.x.categories = {name, "b", "c", "d"};
          panel.bars("", Values{1, 2, 3, 4});
        },
        400, 300);
  };
  const Drawing plain = with("a");
  const double slot = plain.width() / 4.0;
  const auto fits = static_cast<std::size_t>(std::floor((slot - 4.0) / 6.6));
  for (const bool too_long : {false, true}) {
    const std::string name(fits + (too_long ? 1 : 0), 'n');
    const Drawing d = with(name);
    const Element text = d.text(name);
    EXPECT_EQ(text.get("transform").empty(), !too_long);
    EXPECT_EQ(text.get("text-anchor"), too_long ? "end" : "middle");
    const double x = d.left() + d.width() * 0.6 / 4.2;
    if (too_long) {
      EXPECT_TRUE(text.get("transform").rfind("rotate(-30 ", 0) == 0);
      EXPECT_NEAR(plain.bottom() - d.bottom(), 0.5 * 6.6 * static_cast<double>(name.size()), 1.0);
      EXPECT_NEAR(text.num("x") - x, 4.0, 1.6);
    } else {
      EXPECT_NEAR(text.num("x"), x, 0.15);
      EXPECT_EQ(plain.bottom(), d.bottom());
    }
    EXPECT_NEAR(text.num("y") - d.bottom(), 17.0, 4.0);
  }
  const Drawing very_long = with(std::string(90, 'n'));
  EXPECT_NEAR(plain.bottom() - very_long.bottom(), 0.35 * 300.0, 3.0) << "not more than that";
  // Categories have no grid lines, and the range ends 0.6 beyond the first and the last of them.
  EXPECT_EQ(plain.all("path", "#dedede").size(), plain.all("text").size() - 4U);
  const Drawing empty = drawn([](Panel& panel) { panel.x.categories = {"a", "b"}; });
  EXPECT_NEAR(empty.text("a").num("x"), empty.left() + empty.width() * 0.6 / 2.2, 0.15);
  EXPECT_NEAR(empty.text("b").num("x"), empty.left() + empty.width() * 1.6 / 2.2, 0.15);
}

TEST(PlotFrame, EqualAxesGrowTheAxisWithRoomAboutItsMiddle) {
  for (const auto& [width, height] : {std::pair(700.0, 300.0), {300.0, 700.0}}) {
    const Drawing d = drawn(
        [](Panel& panel) {
          panel.equal_axes = true;
          panel.line("", Values{20, 24}, Values{10, 14});
        },
        width, height);
    const auto p = d.all("polyline")[0].points();
    EXPECT_NEAR(p[1].x - p[0].x, p[0].y - p[1].y, 0.21);
    EXPECT_NEAR(0.5 * (p[0].x + p[1].x), 0.5 * (d.left() + d.right()), 0.21);
    EXPECT_NEAR(0.5 * (p[0].y + p[1].y), 0.5 * (d.top() + d.bottom()), 0.21);
    // The range with its room fills the shorter side.
    EXPECT_NEAR(p[1].x - p[0].x, std::min(d.width(), d.height()) / 1.1, 0.3);
  }
}

TEST(PlotFigure, PanelsStandInRowsBelowTheTitle) {
  for (const bool titled : {false, true}) {
    for (const auto& [count, columns, width, rows] :
         {std::tuple(1, 3, 200.0, 1), {3, 2, 400.0, 2}, {4, 2, 400.0, 2}, {5, 2, 400.0, 3}, {0, 2, 200.0, 0}}) {
      Figure figure(titled ? "Title" : "", columns);
      figure.set_panel_size(200, 150);
      for (int i = 0; i < count; ++i) figure.add_panel("panel " + std::to_string(i));
      const Drawing d(figure.svg());
      const double top = titled ? 34.0 : 0.0;
      EXPECT_EQ(d.elements[0].num("width"), width);
      EXPECT_NEAR(d.elements[0].num("height"), top + 150.0 * rows, titled ? 6.0 : 0.0);
      const double real_top = d.elements[0].num("height") - 150.0 * rows;
      const auto background = d.all("rect", "#fff").at(0);
      EXPECT_EQ(background.num("width"), width);
      EXPECT_EQ(background.num("height"), d.elements[0].num("height"));
      const auto frames = d.all("rect", "stroke=\"#222\"");
      ASSERT_EQ(frames.size(), static_cast<std::size_t>(count));
      for (int i = 0; i < count; ++i) {
        EXPECT_NEAR(frames[i].num("x") - frames[0].num("x"), 200.0 * (i % columns), 0.11);
        EXPECT_NEAR(frames[i].num("y") - frames[0].num("y"), 150.0 * (i / columns), 0.11);
        EXPECT_GT(frames[i].num("y"), real_top);
      }
      if (!titled) continue;
      const Element title = d.text("Title");
      EXPECT_NEAR(title.num("x"), 0.5 * width, 0.11);
      EXPECT_NEAR(title.num("y"), 23.0, 5.0);
      EXPECT_LT(title.num("y"), real_top - 4.0);
      EXPECT_NEAR(title.num("font-size"), 15.0, 3.0);
    }
  }
}

// ---- Ticks, text and points.

TEST(PlotTicks, StepsAreOneTwoOrFiveWhateverIsNearest) {
  for (const auto& [extent, step] : {std::pair(1.49, 1.0),
                                     {1.51, 2.0},
                                     {3.49, 2.0},
                                     {3.51, 5.0},
                                     {7.49, 5.0},
                                     {7.51, 10.0},
                                     {9.9, 10.0},
                                     {0.0149, 0.01},
                                     {1490.0, 1000.0}}) {
    const auto ticks = linear_ticks(0.0, extent * 10.0, 10);
    ASSERT_GE(ticks.size(), 2U);
    EXPECT_NEAR(ticks[1].value - ticks[0].value, step, 1e-9 * step) << extent;
    EXPECT_EQ(ticks[0].value, 0.0);
    EXPECT_LE(ticks.back().value, extent * 10.0);
    EXPECT_GT(ticks.back().value + step, extent * 10.0);
  }
  EXPECT_EQ(linear_ticks(0.0, 1.0, 0).size(), linear_ticks(0.0, 1.0, 1).size());
  // Ends that are ticks but for their last bits are ticks.
  EXPECT_EQ(linear_ticks(0.1 + 0.2, 0.7, 4).front().label, "0.3");
  EXPECT_EQ(linear_ticks(0.3, 0.1 * 7.0 - 1e-12, 4).back().label, "0.7");
}

TEST(PlotTicks, NumbersArePlainFromATenThousandthToAHundredThousand) {
  const auto last = [](double low, double high) { return linear_ticks(low, high, 4).back().label; };
  EXPECT_EQ(last(0.0, 80000.0), "80000");
  EXPECT_EQ(last(0.0, 99999.0), "80000");
  EXPECT_EQ(last(0.0, 100000.0), "1·10⁵");
  EXPECT_EQ(last(-100000.0, 0.0), "0");
  EXPECT_EQ(linear_ticks(-100000.0, 0.0, 4).front().label, "-1·10⁵");
  EXPECT_EQ(last(0.0, 0.0001), "0.0001");
  EXPECT_EQ(last(0.0, 0.000099), "8·10⁻⁵");
  EXPECT_EQ(last(0.0, 3.0e12), "3·10¹²");
  EXPECT_EQ(last(0.0, 2.5), "2.5");
  EXPECT_EQ(linear_ticks(0.0, 0.5, 5)[1].label, "0.1");
}

TEST(PlotTicks, OfDecadesHaveMinorOnesAndSkipWhereThereAreMany) {
  const auto count = [](const std::vector<Tick>& ticks, bool labeled) {
    return std::count_if(ticks.begin(), ticks.end(), [&](const Tick& t) { return t.label.empty() != labeled; });
  };
  const auto two = log_ticks(1.0, 100.0, 10);
  EXPECT_EQ(count(two, true), 3);
  EXPECT_EQ(count(two, false), 16);
  for (std::size_t i = 1; i < two.size(); ++i) EXPECT_GT(two[i].value, two[i - 1].value);
  EXPECT_EQ(two[1].value, 2.0);
  EXPECT_EQ(two[10].value, 20.0);
  // Less than 1.6 decades: also 2 and 5.
  EXPECT_EQ(count(log_ticks(1.0, 39.0, 5), true), 5);
  EXPECT_EQ(count(log_ticks(1.0, 41.0, 5), true), 2);
  // More than eight decades: no minor ones; every second labeled where wanted.
  EXPECT_EQ(count(log_ticks(1.0, 1e8, 20), false), 64);
  EXPECT_EQ(count(log_ticks(1.0, 1.1e8, 20), false), 0);
  const auto skipped = log_ticks(1e-4, 1e6, 5);
  EXPECT_EQ(count(skipped, true), 6);
  for (const Tick& t : skipped) {
    if (t.label.empty()) continue;
    EXPECT_EQ(std::lround(std::log10(t.value)) % 2, 0) << t.label;
  }
  // Labels: plain from a thousandth to ten thousand.
  const auto labels = log_ticks(1e-4, 1e6, 20);
  std::vector<std::string> texts;
  for (const Tick& t : labels) {
    if (!t.label.empty()) texts.push_back(t.label);
  }
  EXPECT_EQ(texts, (std::vector<std::string>{"10⁻⁴", "0.001", "0.01", "0.1", "1", "10", "100", "1000", "10000", "10⁵",
                                             "10⁶"}));
  const auto small = log_ticks(1e-5, 5e-5, 5);
  EXPECT_EQ(small.front().label, "10⁻⁵");
  EXPECT_EQ(small[1].label, "2·10⁻⁵");
  EXPECT_EQ(small.back().label, "5·10⁻⁵");
  // Both ends count although their logarithms are not exact.
  EXPECT_EQ(log_ticks(0.001, 1000.0, 10).front().value, 0.001);
  EXPECT_NEAR(log_ticks(0.001, 1000.0, 10).back().value, 1000.0, 1e-6);
}

TEST(PlotText, IsSixTenthsOfItsSizeWideForEachLetter) {
  EXPECT_NEAR(text_width("abcd", 10.0), 24.0, 3.0);
  EXPECT_EQ(text_width("10⁻⁶", 10.0), text_width("abcd", 10.0)) << "letters, not bytes";
  EXPECT_EQ(text_width("", 10.0), 0.0);
}

TEST(SvgWriter, KeepsFirstExtremesAndLastOfACrowdInAPixelColumn) {
  const auto kept = [](const std::vector<PointPx>& points) {
    SvgWriter svg(100, 100, "");
    svg.polyline(points, "");
    return Drawing(svg.finish()).all("polyline").at(0).points();
  };
  EXPECT_EQ(kept({{5.0, 1}, {5.2, 2}, {5.4, 3}, {5.8, 4}}).size(), 4U);
  const auto five = kept({{5.0, 10}, {5.1, 30}, {5.2, 20}, {5.4, 5}, {5.6, 15}, {5.9, 12}});
  ASSERT_EQ(five.size(), 4U);
  EXPECT_EQ(five[0].y, 10.0);
  EXPECT_EQ(five[1].y, 30.0);
  EXPECT_EQ(five[2].y, 5.0);
  EXPECT_EQ(five[3].y, 12.0);
  const auto down_first = kept({{5.0, 10}, {5.1, 3}, {5.2, 20}, {5.4, 35}, {5.6, 15}, {5.9, 12}});
  ASSERT_EQ(down_first.size(), 4U);
  EXPECT_EQ(down_first[1].y, 3.0);
  EXPECT_EQ(down_first[2].y, 35.0);
  EXPECT_EQ(kept({{5.0, 1}, {5.0, 1}, {5.04, 1.04}, {7.0, 2}}).size(), 2U) << "the same place but for a twentieth";
  EXPECT_EQ(kept({{5.9, 1}, {6.0, 2}, {6.9, 3}, {7.0, 4}}).size(), 4U);
}

TEST(SvgWriter, WritesSizesInMillimetersWherePrinted) {
  EXPECT_EQ(Drawing(SvgWriter(200, 100, "", 50.0).finish()).elements[0].get("width"), "50mm");
  EXPECT_EQ(Drawing(SvgWriter(200, 100, "", 50.0).finish()).elements[0].get("height"), "25mm");
  EXPECT_EQ(Drawing(SvgWriter(200, 100, "").finish()).elements[0].get("width"), "200");
  EXPECT_EQ(Drawing(SvgWriter(200.04, 100.06, "").finish()).elements[0].get("viewBox"), "0 0 200 100.1");
}

TEST(PlotBox, OfFewSamplesInterpolatesAndIgnoresWhatIsNoNumber) {
  const Box one = box_of(Values{3.0, std::nan("")});
  for (const double value : {one.low, one.q1, one.median, one.q3, one.high, one.mean}) EXPECT_EQ(value, 3.0);
  const Box two = box_of(Values{4.0, 0.0});
  EXPECT_EQ(two.q1, 1.0);
  EXPECT_EQ(two.median, 2.0);
  EXPECT_EQ(two.q3, 3.0);
  // Quartiles 2 and 4: whiskers up to 3 beyond them count, and no further.
  const Box reach = box_of(Values{-1.0, 2.0, 3.0, 4.0, 7.0});
  EXPECT_EQ(reach.low, -1.0);
  EXPECT_EQ(reach.high, 7.0);
  EXPECT_TRUE(reach.outliers.empty());
  const Box beyond = box_of(Values{-1.01, 2.0, 3.0, 4.0, 7.01});
  EXPECT_EQ(beyond.low, 2.0);
  EXPECT_EQ(beyond.high, 4.0);
  EXPECT_EQ(beyond.outliers, (Values{-1.01, 7.01}));
}

}  // namespace
}  // namespace swiftlet::sim::plot
