// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/canvas.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "render_support.hpp"

namespace swiftlet::sim {
namespace {

using testing::HasSubstr;

/// Every kind of mark.
Figure test_figure() {
  return {300, 200, [](Canvas& canvas) {
            canvas.picture(10, 20, Image(50, 40, Rgb(0.0F, 0.0F, 1.0F)));
            canvas.rectangle({100, 20, 40, 30}, {1, 0, 0});
            canvas.line({100, 100}, {140, 100}, 5.0F, {0, 1, 0});
            canvas.ring({220, 100}, 20.0F, 4.0F, {0, 0, 0});
            canvas.text({20, 180}, "uav<1> & \"two\"", {.height_px = 20.0F, .color = Rgb::Zero(), .halo_alpha = 0.0F});
          }};
}

/// Checks that all tags are closed in order and all else is escaped; elements and attributes are not checked.
std::string not_well_formed(std::string_view xml) {
  std::vector<std::string> open;
  while (!xml.empty()) {
    if (xml.front() == '&') {
      const std::string_view name = xml.substr(1, xml.find(';') - 1);
      if (name != "amp" && name != "lt" && name != "gt" && name != "quot" && name != "#39") return "a bare &";
    }
    if (xml.front() == '>') return "a bare >";
    if (xml.front() != '<') {
      xml.remove_prefix(1);
      continue;
    }
    const std::size_t end = xml.find('>');
    if (end == std::string_view::npos) return "a tag that does not end";
    const std::string_view tag = xml.substr(1, end - 1);
    if (tag.find('<') != std::string_view::npos) return "a bare <";
    if (std::count(tag.begin(), tag.end(), '"') % 2 != 0) return "a quote that does not end";
    const std::string name(tag.substr(0, tag.find_first_of(" /", 1)));
    if (tag.front() == '/') {
      if (open.empty() || "/" + open.back() != tag) return "not open: " + std::string(tag);
      open.pop_back();
    } else if (tag.back() != '/') {
      open.push_back(name);
    }
    xml.remove_prefix(end + 1);
  }
  return open.empty() ? "" : "not closed: " + open.back();
}

TEST(Canvas, DrawsPixelsInTheRightPlace) {
  const Image image = test_figure().pixels(Rgb::Ones());
  EXPECT_TRUE(is_dominated_by(color_at(image, 30, 40), 2));
  EXPECT_TRUE(is_dominated_by(color_at(image, 120, 35), 0));
  EXPECT_TRUE(is_dominated_by(color_at(image, 120, 100), 1));
  EXPECT_EQ(color_at(image, 120, 106), Rgb::Ones()) << "the line is 5 px wide";
  EXPECT_LT(brightness(color_at(image, 240, 100)), 0.1F);
  EXPECT_EQ(color_at(image, 220, 100), Rgb::Ones()) << "a ring is empty";
}

TEST(Canvas, OfPixelsClipsAtItsEdges) {
  Image image(40, 30, Rgb::Ones());
  PixelCanvas canvas(image);
  canvas.picture(-20, -10, Image(30, 20, Rgb::Zero()));
  canvas.picture(35, 25, Image(30, 20, Rgb::Zero()));
  canvas.picture(90, 90, Image(30, 20, Rgb::Zero()));
  canvas.ring({0, 0}, 100.0F, 3.0F, {1, 0, 0});
  canvas.line({-50, 15}, {90, 15}, 1.0F, {1, 0, 0});
  EXPECT_EQ(color_at(image, 9, 9), Rgb::Zero());
  EXPECT_EQ(color_at(image, 10, 9), Rgb::Ones());
  EXPECT_EQ(color_at(image, 35, 25), Rgb::Zero());
  EXPECT_EQ(color_at(image, 34, 25), Rgb::Ones());
  EXPECT_TRUE(is_dominated_by(color_at(image, 20, 15), 0));
}

TEST(Canvas, WritesWellFormedSvgWithText) {
  const std::string svg = test_figure().svg(300.0, "a <title> & more");
  EXPECT_EQ(not_well_formed(svg), "");
  EXPECT_THAT(svg, HasSubstr("uav&lt;1&gt; &amp; &quot;two&quot;</text>"));
  EXPECT_THAT(svg, HasSubstr("<title>a &lt;title&gt; &amp; more</title>"));
  EXPECT_THAT(svg, HasSubstr("href=\"data:image/png;base64,iVBORw0KGgo"));
  // 300 px at 300 dpi are an inch.
  EXPECT_THAT(svg, HasSubstr("width=\"25.4mm\" height=\"16.933mm\" viewBox=\"0 0 300 200\""));
}

}  // namespace
}  // namespace swiftlet::sim
