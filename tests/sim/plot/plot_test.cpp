// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/plot/plot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "sim/plot/ticks.hpp"
#include "swiftlet/sim/plot/svg_writer.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim::plot {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string> labels(const std::vector<Tick>& ticks) {
  std::vector<std::string> texts;
  for (const Tick& tick : ticks) {
    if (!tick.label.empty()) texts.push_back(tick.label);
  }
  return texts;
}

int count_of(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// Coordinates of the first polyline.
std::vector<std::pair<double, double>> polyline_of(const std::string& svg) {
  const std::size_t begin = svg.find("points=\"") + 8;
  std::istringstream in(svg.substr(begin, svg.find('"', begin) - begin));
  std::vector<std::pair<double, double>> points;
  double x = 0.0, y = 0.0;
  for (char comma = 0; in >> x >> comma >> y;) points.emplace_back(x, y);
  return points;
}

TEST(PlotTicks, AreRoundWithMinimalDigits) {
  EXPECT_THAT(labels(linear_ticks(0.0, 1.0, 5)), ElementsAre("0", "0.2", "0.4", "0.6", "0.8", "1"));
  EXPECT_THAT(labels(linear_ticks(-3.2, 3.9, 4)), ElementsAre("-2", "0", "2"));
  EXPECT_THAT(labels(linear_ticks(0.012, 0.033, 4)), ElementsAre("0.015", "0.02", "0.025", "0.03"));
}

TEST(PlotTicks, ShareThePowerOfTheLargest) {
  EXPECT_THAT(labels(linear_ticks(0.0, 2.0e-6, 4)), ElementsAre("0", "0.5·10⁻⁶", "1·10⁻⁶", "1.5·10⁻⁶", "2·10⁻⁶"));
}

TEST(PlotTicks, OfALogarithmicAxisAreDecades) {
  EXPECT_THAT(labels(log_ticks(1e-6, 1e2, 10)),
              ElementsAre("10⁻⁶", "10⁻⁵", "10⁻⁴", "0.001", "0.01", "0.1", "1", "10", "100"));
  EXPECT_THAT(labels(log_ticks(1.0, 20.0, 5)), ElementsAre("1", "2", "5", "10", "20"));
}

TEST(PlotTicks, NumberTextIsShort) {
  EXPECT_EQ(number_text(-0.04, 1), "0");
  EXPECT_EQ(number_text(2.50, 2), "2.5");
  EXPECT_EQ(number_text(100.0, 0), "100");
}

TEST(Plot, DrawsDiagonalLineAcrossItsFrame) {
  Figure figure;
  figure.set_panel_size(400, 300);
  Panel& panel = figure.add_panel();
  panel.x.min = panel.y.min = 0.0;
  panel.x.max = panel.y.max = 2.0;
  const std::vector<double> x{0.0, 1.0, 2.0}, y{0.0, 1.0, 2.0};
  panel.line("", x, y);
  const auto points = polyline_of(figure.svg());
  ASSERT_EQ(points.size(), 3u);
  EXPECT_NEAR(points[1].first, 0.5 * (points[0].first + points[2].first), 0.11);
  EXPECT_NEAR(points[1].second, 0.5 * (points[0].second + points[2].second), 0.11);
  EXPECT_LT(points[2].second, points[0].second);  // up is up
}

// All figures of a page share one namespace, and the first definition of a name wins.
TEST(Plot, ConfinesClippingToEachFigure) {
  const std::vector<double> x{0.0, 1.0}, y{0.0, 1.0};
  const auto clip_of = [&](double width_px, double height_px) {
    Figure figure;
    figure.set_panel_size(width_px, height_px);
    figure.add_panel().line("", x, y);
    const std::string svg = figure.svg();
    const std::size_t begin = svg.find("<clipPath id=\"") + 14;
    return svg.substr(begin, svg.find('"', begin) - begin);
  };
  EXPECT_NE(clip_of(400, 300), clip_of(400, 200));
  EXPECT_NE(clip_of(400, 300), clip_of(300, 300));
  EXPECT_EQ(clip_of(400, 300), clip_of(400, 300));  // equal rectangles have equal names
}

TEST(Plot, GivesLogarithmicDecadesEqualLength) {
  Figure figure;
  Panel& panel = figure.add_panel();
  panel.y.log = true;
  const std::vector<double> x{0.0, 1.0, 2.0}, y{0.01, 1.0, 100.0};
  panel.line("", x, y);
  const auto points = polyline_of(figure.svg());
  ASSERT_EQ(points.size(), 3u);
  EXPECT_NEAR(points[0].second - points[1].second, points[1].second - points[2].second, 0.11);
}

TEST(Plot, BreaksLogarithmicLinesAtNonpositiveValues) {
  Figure figure;
  Panel& panel = figure.add_panel();
  panel.y.log = true;
  const std::vector<double> x{0, 1, 2, 3, 4}, y{1.0, 10.0, 0.0, 10.0, 1.0};
  panel.line("", x, y);
  EXPECT_EQ(count_of(figure.svg(), "<polyline"), 2);
}

TEST(Plot, BreaksLinesAtNanWithoutPrinting) {
  Figure figure;
  Panel& panel = figure.add_panel();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> x{0, 1, 2, 3, 4}, y{1.0, 2.0, nan, 2.0, std::numeric_limits<double>::infinity()},
      one(5, 1.0);
  panel.line("a", x, y).scatter("b", x, y).band("c", x, y, one).bars("d", y);
  const std::string svg = figure.svg();
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

TEST(Plot, DecimatesManyPointsKeepingTheirPeak) {
  Figure figure;
  Panel& panel = figure.add_panel();
  panel.y.min = 0.0;
  panel.y.max = 10.0;
  std::vector<double> x(100000), y(100000, 1.0);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<double>(i);
  y[77777] = 10.0;
  panel.line("", x, y);
  const std::string svg = figure.svg();
  EXPECT_LT(svg.size(), 60000u);
  double top = 1e9, usual = 0.0;
  for (const auto& [px, py] : polyline_of(svg)) {
    top = std::min(top, py);
    usual = std::max(usual, py);
  }
  EXPECT_GT(usual - top, 200.0);
}

TEST(Plot, GivesIdenticalBytesWhenRepeated) {
  const auto draw = [] {
    Figure figure("Twice", 2);
    const std::vector<double> x{0, 1, 2}, y{3, 1, 2};
    figure.add_panel("a").line("one", x, y).scatter("two", x, y);
    figure.add_panel("b").bars("value", y);
    return figure.svg();
  };
  EXPECT_EQ(draw(), draw());
}

TEST(Plot, TextIsEscaped) {
  Figure figure("a < b & \"c\"");
  figure.add_panel().x.label = "<x>";
  const std::string svg = figure.svg();
  EXPECT_THAT(svg, HasSubstr("a &lt; b &amp; &quot;c&quot;"));
  EXPECT_THAT(svg, HasSubstr("&lt;x&gt;"));
}

TEST(Plot, SeriesOfUnequalLengthAreRefused) {
  Figure figure;
  const std::vector<double> two(2, 0.0), three(3, 0.0);
  EXPECT_THROW(figure.add_panel().line("speed", two, three), std::invalid_argument);
}

TEST(Plot, LegendShowsLabelsAndAvoidsData) {
  Figure figure;
  figure.set_panel_size(500, 400);
  Panel& panel = figure.add_panel();
  std::vector<double> x, y;
  for (int i = 0; i <= 50; ++i) {  // fills the upper right half: the lower right corner is free
    x.push_back(i);
    y.push_back(50.0 - 0.9 * i);
    x.push_back(50.0);
    y.push_back(50.0);
  }
  panel.line("named", x, y).line("", x, y);
  const std::string svg = figure.svg();
  EXPECT_EQ(count_of(svg, ">named</text>"), 1);
  EXPECT_EQ(count_of(svg, "stroke=\"#ccc\""), 1);  // inside, framed
}

TEST(Plot, ScalesEqualAxesAlike) {
  Figure figure;
  figure.set_panel_size(700, 300);
  Panel& panel = figure.add_panel();
  panel.equal_axes = true;
  const std::vector<double> x{0, 1, 1}, y{0, 0, 1};
  panel.line("", x, y);
  const auto points = polyline_of(figure.svg());
  ASSERT_EQ(points.size(), 3u);
  EXPECT_NEAR(points[1].first - points[0].first, points[1].second - points[2].second, 0.21);
  EXPECT_GT(points[1].first - points[0].first, 150.0);  // the largest size in a frame of 300 px
}

TEST(Plot, DrawsQuartilesAndTukeyWhiskers) {
  const std::vector<double> samples{5, 1, 2, 3, 4, 100};
  const Box box = box_of(samples);
  EXPECT_DOUBLE_EQ(box.median, 3.5);
  EXPECT_DOUBLE_EQ(box.mean, 115.0 / 6.0);
  EXPECT_DOUBLE_EQ(box.q1, 2.25);
  EXPECT_DOUBLE_EQ(box.q3, 4.75);
  EXPECT_DOUBLE_EQ(box.low, 1.0);
  EXPECT_DOUBLE_EQ(box.high, 5.0);
  EXPECT_THAT(box.outliers, ElementsAre(100.0));
  EXPECT_THROW(box_of({}), std::invalid_argument);
}

TEST(Plot, DrawsEmptyFiguresAndPanels) {
  EXPECT_THAT(Figure().svg(), HasSubstr("</svg>"));
  Figure figure;
  figure.add_panel("nothing yet");
  EXPECT_THAT(figure.svg(), HasSubstr("nothing yet"));
}

TEST(Plot, TakesItsNameOnlyWhenComplete) {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "sub" / "figure.svg";
  Figure figure("Written");
  figure.add_panel();
  figure.write(path);
  std::ifstream in(path);
  const std::string content((std::istreambuf_iterator<char>(in)), {});
  EXPECT_EQ(content, figure.svg());
  EXPECT_FALSE(std::filesystem::exists(path.string() + ".part"));
  EXPECT_THROW(figure.write("/dev/null/figure.svg"), std::runtime_error);
}

TEST(Plot, LimitsTicksOfNearlyEqualValues) {
  const std::pair<double, double> pairs[] = {
      {0.3, 0.30000000000000004}, {1e300, 1.0000000000000002e300}, {-7.0, -6.999999999999999}, {1e17, 1e17 + 16.0}};
  for (const auto& [low, high] : pairs) {
    EXPECT_LE(linear_ticks(low, high, 5).size(), 20U) << low;
    const double values[] = {low, high};
    Figure figure;
    figure.add_panel().line("a", values, values);
    EXPECT_LT(figure.svg().size(), 100'000U) << low;
  }
}

TEST(Plot, DrawsEveryKindOfMark) {
  Figure figure;
  Panel& panel = figure.add_panel();
  panel.legend = Legend::kOutside;
  const std::vector<double> x{0, 1, 2}, y{3, 1, 2}, low{0, 0, 0};
  panel.line("line", x, y, {.dash = Dash::kDashed}).band("band", x, low, y).bars("bars", y).vertical("event", 1.0);
  for (const auto& [name, marker] :
       {std::pair("circle", Marker::kCircle), {"square", Marker::kSquare}, {"diamond", Marker::kDiamond}}) {
    panel.scatter(name, x, y, {.marker = marker});
  }
  const std::string svg = figure.svg();
  for (const char* name : {"line", "band", "bars", "event", "circle", "square", "diamond"}) {
    EXPECT_EQ(count_of(svg, std::string(">") + name + "</text>"), 1) << name;
  }
  EXPECT_GE(count_of(svg, "<circle"), 4) << "three marks and the legend's";
  EXPECT_THAT(svg, HasSubstr("stroke-dasharray"));
}

TEST(SvgWriter, WritesSizesInMillimetersWherePrinted) {
  EXPECT_THAT(SvgWriter(200, 100, "", 50.0).finish(), HasSubstr("width=\"50mm\" height=\"25mm\""));
  EXPECT_THAT(SvgWriter(200, 100, "").finish(), HasSubstr("width=\"200\""));
}

}  // namespace
}  // namespace swiftlet::sim::plot
