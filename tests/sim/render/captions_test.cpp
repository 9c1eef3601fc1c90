// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/captions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "render_support.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

int pixels_of(const Image& image, const Rgb& color) {
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::uint8_t* p = image.pixel(x, y);
      bool same = true;
      for (int c = 0; c < 3; ++c) same = same && std::abs(p[c] - std::lround(255.0F * color[c])) <= 1;
      count += same;
    }
  }
  return count;
}

/// Notes what is drawn where.
class NotedCanvas : public Canvas {
 public:
  struct Text {
    std::string content;
    Box box;
  };
  using Canvas::Canvas;
  void picture(int left, int top, const Image& image) override {
    pictures.push_back({static_cast<float>(left), static_cast<float>(top), static_cast<float>(image.width),
                        static_cast<float>(image.height)});
  }
  void rectangle(const Box& box, const Rgb& color, float) override {
    rectangles.push_back(box);
    colors.push_back(color);
  }
  void line(const PixelPoint& a_px, const PixelPoint& b_px, float, const Rgb& color) override {
    lines.push_back({a_px, b_px});
    colors.push_back(color);
  }
  void ring(const PixelPoint& center_px, float radius_px, float, const Rgb&) override {
    rings.push_back({center_px.x(), center_px.y(), radius_px});
  }
  void text(const PixelPoint& at_px, std::string_view content, const TextStyle& style) override {
    const float width = kWidestFont * text_width_px(content, style.height_px);
    const float share = style.align == Align::kLeft ? 0.0F : style.align == Align::kCenter ? 0.5F : 1.0F;
    texts.push_back({std::string(content),
                     {at_px.x() - share * width, at_px.y() - style.height_px, width, 1.3F * style.height_px}});
  }
  bool says(const std::string& content) const {
    return std::any_of(texts.begin(), texts.end(), [&](const Text& text) { return text.content == content; });
  }

  std::vector<Box> pictures, rectangles;
  std::vector<Rgb> colors;
  std::vector<std::pair<Eigen::Vector2f, Eigen::Vector2f>> lines;
  std::vector<Eigen::Vector3f> rings;
  std::vector<Text> texts;
};

bool overlap(const Box& a, const Box& b) {
  return a.left < b.right() - 0.01F && b.left < a.right() - 0.01F && a.top < b.bottom() - 0.01F &&
         b.top < a.bottom() - 0.01F;
}

Sidebar full_sidebar(std::size_t keys) {
  Sidebar sidebar;
  for (std::size_t i = 0; i < keys; ++i)
    sidebar.keys.push_back({"meaning " + std::to_string(i), {0.1F, 0.2F, 0.3F, 1.0F}});
  sidebar.keys.push_back({"a meaning that is told at such a length that no line of a margin holds it", {1, 0, 0, 1}});
  sidebar.bar = ColorBar{turbo_like, -3.0, 17.5, "z [m]"};
  return sidebar;
}

Look paper_look() {
  CameraConfig camera;
  camera.style = PictureMedium::kPaper;
  camera.width_mm = 85.0;
  return look_of(camera);
}

TEST(Sidebar, ShowsEachMeaningOnceInItsColor) {
  const Overlay::Key red{"flying", {1.0F, 0.0F, 0.0F, 0.3F}}, blue{"background", {0.0F, 0.0F, 1.0F, 1.0F}};
  const auto draw = [](std::vector<Overlay::Key> keys) {
    return painted(640, 360, Rgb::Constant(0.5F), [&](Canvas& canvas) {
      draw_sidebar(canvas, {}, {keys, {}}, 640 - sidebar_width_px({keys, {}}, {}));
    });
  };
  const Image once = draw({red, blue}), twice = draw({red, blue, red});
  EXPECT_EQ(once.rgb, twice.rgb);
  EXPECT_GT(pixels_of(once, {1.0F, 0.0F, 0.0F}), 30);
  EXPECT_EQ(pixels_of(once, {1.0F, 0.0F, 0.0F}), pixels_of(once, {0.0F, 0.0F, 1.0F}));
}

TEST(Sidebar, TakesNoRoomWithoutAnythingToTell) { EXPECT_EQ(sidebar_width_px({}, {}), 0); }

TEST(Sidebar, LeavesThePictureAloneAndNothingInItOverlaps) {
  for (const Look& look : {Look{}, paper_look()}) {
    for (const std::size_t keys : {0U, 3U, 9U, 40U}) {
      const Sidebar sidebar = full_sidebar(keys);
      const int width = sidebar_width_px(sidebar, look);
      NotedCanvas canvas(1280, 720);
      draw_sidebar(canvas, look, sidebar, 1280 - width);
      std::vector<Box> texts;
      for (const NotedCanvas::Text& text : canvas.texts) {
        EXPECT_GE(text.box.left, 1280 - width) << text.content << ": over the picture";
        EXPECT_LE(text.box.right(), 1280) << text.content;
        EXPECT_GE(text.box.top, 0.0F) << text.content;
        EXPECT_LE(text.box.bottom(), 720.0F) << text.content << ", " << keys << " keys";
        for (const Box& other : texts)
          EXPECT_FALSE(overlap(text.box, other)) << text.content << ", " << keys << " keys";
        texts.push_back(text.box);
        // The first rectangle is the margin; swatches, steps and ticks of the bar come after it.
        for (std::size_t i = 1; i < canvas.rectangles.size(); ++i)
          EXPECT_FALSE(overlap(text.box, canvas.rectangles[i])) << text.content << ", " << keys << " keys";
      }
      EXPECT_TRUE(canvas.says("z [m]"));
      EXPECT_TRUE(canvas.says("0"));
    }
  }
}

TEST(Sidebar, CountsTheKeysThatFindNoRoom) {
  NotedCanvas canvas(400, 300);
  draw_sidebar(canvas, {}, full_sidebar(40), 200);
  std::size_t told = 0;
  for (std::size_t i = 0; i < 40; ++i) told += canvas.says("meaning " + std::to_string(i)) ? 1 : 0;
  EXPECT_GT(told, 1U);
  EXPECT_TRUE(canvas.says("and " + std::to_string(41 - told) + " more"));
}

TEST(Sidebar, KeepsItsWidthWhenTheValuesChange) {
  // Frames of a video would tremble otherwise.
  Sidebar sidebar = full_sidebar(0);
  const int width = sidebar_width_px(sidebar, {});
  sidebar.bar->high = 3.25;
  EXPECT_EQ(sidebar_width_px(sidebar, {}), width);
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

TEST(VehicleMarks, RingWhatIsTooSmallToBeSeen) {
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
    EXPECT_EQ(ring.z(), 6.0F);
  }
  EXPECT_TRUE(canvas.says("near") && canvas.says("far"));
  EXPECT_FALSE(canvas.says("behind"));
}

TEST(VehicleMarks, AreInTheColorOfTheVehicle) {
  const View view = top_view({0, 0}, 1000.0, 0.0, 50.0, 400, 400);
  PictureScene picture;
  picture.states.resize(2);
  picture.states[1].p_world_m = {100, 100, 10};
  const std::vector<float> radii_m(2, 0.4F);
  const Image image = painted(400, 400, Rgb::Constant(0.5F), [&](Canvas& canvas) {
    draw_vehicle_marks(canvas, {}, view, picture, {{}, radii_m, 16.0F, 0});
  });
  EXPECT_EQ(pixels_of(image, vehicle_color(0)), 0) << "it carries the camera";
  EXPECT_GT(pixels_of(image, vehicle_color(1)), 30);
  EXPECT_EQ(pixels_of(painted(400, 400, Rgb::Constant(0.5F),
                              [&](Canvas& canvas) {
                                draw_vehicle_marks(canvas, {}, view, picture, {{}, radii_m, 0.0F, 0});
                              }),
                      vehicle_color(1)),
            0);
}

TEST(ScaleBar, IsAsLongAsItsRoundNumberOfMeters) {
  for (const double span_m : {30.0, 70.0, 400.0}) {
    const View view = top_view({0, 0}, span_m, 0.0, 10.0, 640, 360);
    NotedCanvas canvas(640, 360);
    draw_scale_bar(canvas, {}, view);
    const double length_m = round_down_nicely(0.2 * 640 / view.pixels_per_m(1.0));
    EXPECT_TRUE(canvas.says(tick_text(length_m, length_m) + " m"));
    // Its rim, the bar, and the dark half.
    ASSERT_EQ(canvas.rectangles.size(), 3U);
    EXPECT_NEAR(canvas.rectangles[1].width, length_m * view.pixels_per_m(1.0), 0.01);
    EXPECT_NEAR(canvas.rectangles[2].width, 0.5 * length_m * view.pixels_per_m(1.0), 0.01);
    EXPECT_LT(canvas.rectangles[0].left, canvas.rectangles[1].left);
    EXPECT_GT(canvas.rectangles[0].right(), canvas.rectangles[1].right());
  }
}

TEST(VehicleMarks, OfATeamAreNamesAboveItsVehiclesAndOfASwarmNot) {
  const View view = top_view({0, 0}, 40.0, 0.0, 10.0, 640, 360);
  for (const std::size_t count : {1U, 10U, 24U, 100U}) {
    PictureScene picture;
    picture.states.resize(count);
    const std::vector<std::string> names(count, "uav");
    const std::vector<float> radii_m(count, 0.4F);
    NotedCanvas canvas(640, 360);
    draw_vehicle_marks(canvas, {}, view, picture, {names, radii_m, 0.0F});
    EXPECT_EQ(canvas.texts.size(), count <= 24 ? count : 0) << count;
  }
}

}  // namespace
}  // namespace swiftlet::sim
