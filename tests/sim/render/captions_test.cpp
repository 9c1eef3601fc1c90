// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/captions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "noted_canvas.hpp"
#include "render_support.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

bool overlap(const Box& a, const Box& b) {
  return a.left < b.right() - 0.01F && b.left < a.right() - 0.01F && a.top < b.bottom() - 0.01F &&
         b.top < a.bottom() - 0.01F;
}

/// Rows that all look different, one of several lines, and a bar.
Sidebar full_sidebar(std::size_t rows) {
  Sidebar sidebar;
  constexpr Sample kSamples[] = {Sample::kSquare, Sample::kDisc, Sample::kDot, Sample::kLine, Sample::kDashes};
  for (std::size_t i = 0; i < rows; ++i)
    sidebar.entries.push_back(
        {"meaning " + std::to_string(i), vehicle_color(static_cast<VehicleId>(i / 5)), kSamples[i % 5]});
  sidebar.entries.push_back({"a meaning of such a length that no line of a margin holds it", Rgb::Zero()});
  sidebar.bar = ColorBar{turbo_like, -3.0, 17.5, "z [m]"};
  return sidebar;
}

Look paper_look() {
  CameraConfig camera;
  camera.style = PictureMedium::kPaper;
  camera.width_mm = 85.0;
  return look_of(camera);
}

TEST(Sidebar, TakesNoSpaceWhenEmpty) { EXPECT_EQ(sidebar_width_px({}, {}), 0); }

TEST(Sidebar, OverlapsNeitherThePictureNorItself) {
  for (const Look& look : {Look{}, paper_look()}) {
    for (const std::size_t rows : {0U, 3U, 9U, 40U}) {
      const Sidebar sidebar = full_sidebar(rows);
      const int width = sidebar_width_px(sidebar, look);
      NotedCanvas canvas(1280, 720);
      draw_sidebar(canvas, look, sidebar, 1280 - width);
      std::vector<Box> texts;
      for (const NotedCanvas::Text& text : canvas.texts) {
        EXPECT_GE(text.box.left, 1280 - width) << text.content << ": over the picture";
        EXPECT_LE(text.box.right(), 1280) << text.content;
        EXPECT_GE(text.box.top, 0.0F) << text.content;
        EXPECT_LE(text.box.bottom(), 720.0F) << text.content << ", " << rows << " rows";
        for (const Box& other : texts)
          EXPECT_FALSE(overlap(text.box, other)) << text.content << ", " << rows << " rows";
        texts.push_back(text.box);
        // The first rectangle is the margin; swatches, steps and ticks of the bar come after it.
        for (std::size_t i = 1; i < canvas.rectangles.size(); ++i)
          EXPECT_FALSE(overlap(text.box, canvas.rectangles[i])) << text.content << ", " << rows << " rows";
      }
      EXPECT_TRUE(canvas.says("z [m]"));
      EXPECT_TRUE(canvas.says("0"));
    }
  }
}

TEST(Sidebar, CountsRowsThatDoNotFit) {
  NotedCanvas canvas(400, 300);
  draw_sidebar(canvas, {}, full_sidebar(40), 150);
  std::size_t shown = 0;
  for (std::size_t i = 0; i < 40; ++i) shown += canvas.says("meaning " + std::to_string(i)) ? 1 : 0;
  EXPECT_GT(shown, 1U);
  EXPECT_TRUE(canvas.says("and " + std::to_string(41 - shown) + " more"));
}

TEST(Legend, DistinguishesRowsAndNamesMeaningsOnce) {
  const Random random(1, "test.legends");
  for (std::uint32_t i = 0; i < 100; ++i) {
    std::vector<LegendEntry> entries;
    for (std::uint32_t k = 0; k < 20; ++k) {
      const auto share = [&](std::uint32_t j) { return static_cast<float>(random.uniform(0.0, 1.0, i, 4 * k + j)); };
      entries.push_back({std::string(1, static_cast<char>('a' + k % 15)),
                         {share(0), share(1), share(2)},
                         static_cast<Sample>(4.99F * share(3))});
    }
    const std::vector<LegendEntry> rows = rows_of(entries);
    std::string meanings;
    for (std::size_t a = 0; a < rows.size(); ++a) {
      for (const char c : rows[a].meaning) meanings += c == ',' || c == ' ' ? "" : std::string(1, c);
      for (std::size_t b = 0; b < a; ++b)
        EXPECT_TRUE(rows[a].sample != rows[b].sample || color_difference(rows[a].color, rows[b].color) >= 0.1F);
    }
    std::sort(meanings.begin(), meanings.end());
    EXPECT_EQ(meanings, "abcdefghijklmno");
  }
}

TEST(Caption, LeavesOutWhatDoesNotFit) {
  NotedCanvas wide(600, 100), narrow(200, 100);
  draw_caption(wide, {}, 600, "forest  /  follow", "t = 1.000 s");
  draw_caption(narrow, {}, 200, "forest  /  follow", "t = 1.000 s");
  EXPECT_EQ(wide.texts.size(), 2U);
  EXPECT_FALSE(overlap(wide.texts[0].box, wide.texts[1].box));
  ASSERT_EQ(narrow.texts.size(), 1U);
  EXPECT_EQ(narrow.texts[0].content, "t = 1.000 s");
}

TEST(Axes, LieAsTheWorldDoes) {
  // Looking east from the west: y is at the left, z up, and x points away.
  NotedCanvas canvas(400, 300);
  draw_axes(canvas, {}, perspective_view({-10, 0, 0}, {0, 0, 0}, 60.0, 400, 300));
  EXPECT_FALSE(canvas.says("x"));
  ASSERT_TRUE(canvas.says("y") && canvas.says("z"));
  const auto find = [&](const char* name) {
    return std::find_if(canvas.texts.begin(), canvas.texts.end(), [&](const auto& t) { return t.content == name; })
        ->box;
  };
  EXPECT_LT(find("y").left + 20.0F, find("z").left);
  EXPECT_LT(find("z").top + 20.0F, find("y").top);
}

TEST(VehicleMarks, RingVehiclesTooSmallToSee) {
  const View view = perspective_view({0, 0, 0}, {1, 0, 0}, 60.0, 1280, 720);
  PictureScene picture;
  picture.states.resize(3);
  picture.states[0].p_world_m = {5, 1, 0};
  picture.states[1].p_world_m = {400, 10, 0};
  picture.states[2].p_world_m = {-5, 0, 0};
  const std::vector<std::string> names = {"near", "far", "behind"};
  const std::vector<float> radii_m(3, 0.4F);
  NotedCanvas canvas(1280, 720);
  draw_vehicle_marks(canvas, {}, view, picture, {names, radii_m, 12.0F});
  ASSERT_EQ(canvas.rings.size(), 2U) << "a rim and the ring itself, around the far one only";
  const Eigen::Vector3d far = *view.project(picture.states[1].p_world_m);
  for (const Eigen::Vector3f& ring : canvas.rings) {
    EXPECT_NEAR(ring.x(), far.x(), 0.01);
    EXPECT_NEAR(ring.y(), far.y(), 0.01);
  }
  EXPECT_TRUE(canvas.says("near") && canvas.says("far"));
  EXPECT_FALSE(canvas.says("behind"));
}

// Vehicles in a crowd, seen from above.
TEST(VehicleMarks, PlaceNamesWithoutOverlap) {
  const View view = top_view({0, 0}, 36.0, 0.0, 10.0, 640, 360);  // 10 px a meter
  const std::vector<std::string> names = {"primary", "secondary", "uav3", "uav4", "uav5"};
  const std::vector<float> radii_m(5, 0.5F);
  PictureScene picture;
  picture.states.resize(5);
  const Eigen::Vector3d places[] = {{0, 0, 1}, {2.5, 0.5, 1}, {-2.5, 0.3, 1}, {0, 17.5, 1}, {-31.5, 0, 1}};
  for (std::size_t v = 0; v < 5; ++v) picture.states[v].p_world_m = places[v];
  NotedCanvas canvas(640, 360);
  draw_vehicle_marks(canvas, {}, view, picture, {names, radii_m, 0.0F});
  ASSERT_EQ(canvas.texts.size(), 5U);
  for (std::size_t a = 0; a < 5; ++a) {
    const Box& name = canvas.texts[a].box;
    EXPECT_TRUE(name.left >= 0.0F && name.right() <= 640.0F && name.top >= 0.0F && name.bottom() <= 360.0F) << names[a];
    for (std::size_t b = 0; b < a; ++b) EXPECT_FALSE(overlap(name, canvas.texts[b].box)) << names[a] << " " << names[b];
    for (const VehicleState& state : picture.states) {
      const Eigen::Vector3f at = view.project(state.p_world_m)->cast<float>();
      EXPECT_FALSE(overlap(name, {at.x() - 4.0F, at.y() - 4.0F, 8.0F, 8.0F})) << names[a];
    }
  }
}

TEST(ScaleBar, HasTheLengthOfItsLabel) {
  for (const double span_m : {30.0, 70.0, 400.0}) {
    const View view = top_view({0, 0}, span_m, 0.0, 10.0, 640, 360);
    NotedCanvas canvas(640, 360);
    draw_scale_bar(canvas, {}, view);
    const double length_m = round_down_nicely(0.2 * 640 / view.pixels_per_m(1.0));
    EXPECT_TRUE(canvas.says(tick_text(length_m, length_m) + " m"));
    ASSERT_GE(canvas.rectangles.size(), 2U) << "a rim and the bar";
    EXPECT_NEAR(canvas.rectangles[1].width, length_m * view.pixels_per_m(1.0), 0.01);
  }
}

}  // namespace
}  // namespace swiftlet::sim
