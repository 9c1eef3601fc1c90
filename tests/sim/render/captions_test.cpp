// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/captions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "noted_canvas.hpp"
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

// ---- How it is laid out, in heights of a capital.

CameraConfig camera_of(int width_px, int height_px) {
  CameraConfig camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  return camera;
}

TEST(Look, LettersAreAFiftySixthOfTheShorterSideAndReadableOnAnyPicture) {
  EXPECT_FLOAT_EQ(look_of(camera_of(1280, 720)).text_px, 720.0F / 56.0F);
  EXPECT_FLOAT_EQ(look_of(camera_of(672, 2000)).text_px, 12.0F);
  EXPECT_FLOAT_EQ(look_of(camera_of(160, 90)).text_px, 8.0F) << "at least";
  EXPECT_FLOAT_EQ(look_of(camera_of(8000, 6000)).text_px, 40.0F) << "at most";
  const Look screen = look_of(camera_of(1280, 720));
  EXPECT_TRUE(screen.captions);
  EXPECT_EQ(screen.line_scale, 1.0F);
  EXPECT_GT(brightness(screen.ink) - brightness(screen.halo), 0.8F);
}

TEST(Look, OnPaperLettersHaveTheirPointsAndInkIsDarkOnWhite) {
  CameraConfig camera;
  camera.style = PictureMedium::kPaper;
  for (const double dpi : {150.0, 200.0, 300.0, 600.0}) {
    camera.dpi = dpi;
    camera.text_pt = 9.0;
    const Look look = look_of(camera);
    // A capital is seven tenths of the size of the letters; a point is 1 / 72 of an inch.
    EXPECT_NEAR(look.text_px, 0.7 * 9.0 / 72.0 * dpi, 1e-4);
    EXPECT_NEAR(look.line_scale, std::max(1.0, dpi / 200.0), 1e-6);
  }
  const Look look = look_of(camera);
  EXPECT_LT(look.ink.maxCoeff(), 0.1F);
  EXPECT_GT(look.ink.minCoeff(), 0.03F) << "not harder than letters of a book";
  EXPECT_EQ(look.halo, Rgb::Ones());
  EXPECT_EQ(look.page, Rgb::Ones());
  EXPECT_NEAR(look.halo_alpha, 0.8F, 0.2F);
  EXPECT_LE(look.halo_alpha, 1.0F);
  EXPECT_FALSE(look.captions);
  EXPECT_GT(look.nothing.z() - look.nothing.x(), 0.05F) << "bluish: no gray, which means something";
  EXPECT_GT(brightness(look.nothing), 0.75F);
  EXPECT_LE(look.nothing.maxCoeff(), 1.0F);
}

TEST(Look, ItsTextHasAShareOfItsHeightAndItsInk) {
  Look look = paper_look();
  const TextStyle style = look.text(0.5F, Align::kRight);
  EXPECT_EQ(style.height_px, 0.5F * look.text_px);
  EXPECT_EQ(style.color, look.ink);
  EXPECT_EQ(style.halo, look.halo);
  EXPECT_EQ(style.halo_alpha, look.halo_alpha);
  EXPECT_EQ(style.align, Align::kRight);
}

TEST(Caption, KeepsAMarginAndItsPartsApart) {
  Look look;
  look.text_px = 10.0F;
  const std::string left = "forest  /  follow", right = "t = 1.000 s";
  const float needed = text_width_px(left, 10.0F) + text_width_px(right, 10.0F) + 20.0F + 24.0F;
  for (const int more : {-1, 1}) {
    const int width = static_cast<int>(std::floor(needed)) + (more > 0 ? 1 : 0);
    NotedCanvas canvas(width + 300, 200);
    draw_caption(canvas, look, width, left, right);
    ASSERT_EQ(canvas.texts.size(), more > 0 ? 2U : 1U);
    const NotedCanvas::Text& time = canvas.texts.back();
    EXPECT_EQ(time.content, right);
    EXPECT_EQ(time.style.align, Align::kRight);
    EXPECT_NEAR(time.at_px.x(), static_cast<float>(width) - 12.0F, 0.01F);
    EXPECT_EQ(time.style.height_px, 10.0F);
    for (const NotedCanvas::Text& text : canvas.texts) EXPECT_NEAR(text.at_px.y(), 200.0F - 11.0F, 3.0F);
    if (more > 0) {
      EXPECT_NEAR(canvas.texts[0].at_px.x(), 12.0F, 3.0F);
    }
  }
}

TEST(ScaleBar, StandsAboveTheCaptionOrWhereItWouldBe) {
  const View view = top_view({0, 0}, 90.0, 0.0, 10.0, 640, 360);
  for (const bool captions : {true, false}) {
    for (const float text_px : {6.0F, 20.0F}) {
      Look look;
      look.captions = captions;
      look.text_px = text_px;
      NotedCanvas canvas(640, 360);
      draw_scale_bar(canvas, look, view);
      ASSERT_EQ(canvas.rectangles.size(), 3U);
      const Box &rim = canvas.rectangles[0], &bar = canvas.rectangles[1], &half = canvas.rectangles[2];
      EXPECT_NEAR(bar.left, 1.2F * text_px, 0.3F * text_px);
      EXPECT_NEAR(360.0F - bar.top, (captions ? 3.6F : 1.6F) * text_px, 0.5F * text_px);
      const float thick = text_px > 8.0F ? 5.0F : 2.0F;  // a quarter, two pixels at least
      EXPECT_NEAR(bar.height, thick, 0.3F * thick);
      EXPECT_NEAR(bar.top - rim.top, text_px > 8.0F ? 2.4F : 2.0F, 0.6F);
      EXPECT_NEAR(bar.left - rim.left, bar.top - rim.top, 1e-3F);
      EXPECT_NEAR(rim.right() - bar.right(), bar.left - rim.left, 1e-3F);
      EXPECT_NEAR(rim.bottom() - bar.bottom(), bar.left - rim.left, 1e-3F);
      EXPECT_EQ(half.left, bar.left);
      EXPECT_EQ(half.top, bar.top);
      EXPECT_EQ(half.height, bar.height);
      EXPECT_NEAR(half.width, 0.5F * bar.width, 1e-3F);
      EXPECT_NEAR(canvas.alphas[0], 0.7F, 0.25F);
      EXPECT_LT(canvas.alphas[0], 1.0F) << "the picture shines through the rim";
      // The halves are told from each other and from the rim.
      EXPECT_GT(std::abs(brightness(canvas.colors[1]) - brightness(canvas.colors[2])), 0.35F);
      EXPECT_GT(std::abs(brightness(canvas.colors[0]) - brightness(canvas.colors[2])), 0.15F);
      ASSERT_EQ(canvas.texts.size(), 1U);
      EXPECT_NEAR(canvas.texts[0].at_px.x(), bar.left + 0.5F * bar.width, 1e-3F);
      EXPECT_EQ(canvas.texts[0].style.align, Align::kCenter);
      const float gap = bar.top - canvas.texts[0].at_px.y();
      EXPECT_NEAR(gap, 0.7F * text_px, 0.3F * text_px);
      EXPECT_NEAR(canvas.texts[0].style.height_px, 0.9F * text_px, 0.25F * text_px);
      // A fifth of the picture at most, and more than a fifteenth.
      EXPECT_LE(bar.width, 0.2F * 640.0F + 0.01F);
      EXPECT_GT(bar.width, 0.2F * 640.0F / 2.6F);
    }
  }
}

TEST(Axes, StandInTheLowerRightCornerEachInItsColor) {
  for (const bool captions : {true, false}) {
    Look look;
    look.captions = captions;
    look.text_px = 10.0F;
    const View view = perspective_view({-10, -8, 6}, {0, 0, 0}, 60.0, 400, 300);
    NotedCanvas canvas(400, 300);
    draw_axes(canvas, look, view);
    ASSERT_EQ(canvas.lines.size(), 6U);
    ASSERT_EQ(canvas.texts.size(), 3U);
    std::map<std::string, double> towards_eye;
    std::vector<std::string> order;
    for (std::size_t i = 0; i < 3; ++i) {
      const NotedCanvas::Text& text = canvas.texts[i];
      const int axis = text.content[0] - 'x';
      order.push_back(text.content);
      const Eigen::Vector3d camera = view.T_camera_world.block<3, 1>(0, axis);
      towards_eye[text.content] = camera.z();
      const Eigen::Vector2f along(static_cast<float>(camera.x()), static_cast<float>(-camera.y()));
      for (const std::size_t line : {2 * i, 2 * i + 1}) {
        EXPECT_NEAR(canvas.lines[line].first.x(), 400.0F - 50.0F, 12.0F);
        EXPECT_NEAR(canvas.lines[line].first.y(), 300.0F - (captions ? 64.0F : 44.0F), 12.0F);
        const Eigen::Vector2f drawn = canvas.lines[line].second - canvas.lines[line].first;
        EXPECT_NEAR(drawn.norm() / along.norm(), 26.0F, 6.0F);
        EXPECT_NEAR(drawn.normalized().dot(along.normalized()), 1.0F, 1e-4F);
      }
      EXPECT_TRUE(is_dominated_by(canvas.colors[2 * i + 1], axis)) << text.content;
      EXPECT_EQ(canvas.colors[2 * i], look.halo);
      EXPECT_NEAR(canvas.line_widths[2 * i], 3.2F, 1.0F) << "a rim";
      EXPECT_NEAR(canvas.line_widths[2 * i + 1], 1.8F, 0.6F);
      // Its letter lies beyond the tip, centered on the line.
      const Eigen::Vector2f middle = text.at_px - Eigen::Vector2f(0.0F, 0.5F * 9.0F);
      const Eigen::Vector2f beyond = middle - canvas.lines[2 * i + 1].second;
      EXPECT_NEAR(beyond.dot(along.normalized()), 9.0F, 3.0F);
      EXPECT_LT(std::abs(beyond.x() * along.normalized().y() - beyond.y() * along.normalized().x()), 2.0F);
      EXPECT_NEAR(text.style.height_px, 9.0F, 2.0F);
      EXPECT_EQ(text.style.align, Align::kCenter);
    }
    EXPECT_TRUE(std::is_sorted(order.begin(), order.end(), [&](const std::string& a, const std::string& b) {
      return towards_eye[a] < towards_eye[b];
    })) << "the nearest one lies over the others";
  }
}

TEST(Axes, PointingStraightAtWhoLooksAreLeftOut) {
  for (const double tilt_rad : {0.085, 0.12}) {
    NotedCanvas canvas(400, 300);
    draw_axes(canvas, {}, perspective_view({-std::cos(tilt_rad), 0, std::sin(tilt_rad)}, {0, 0, 0}, 60.0, 400, 300));
    EXPECT_EQ(canvas.says("x"), tilt_rad > 0.1);
  }
}

TEST(VehicleMarks, RingsHaveARimAndNamesStandAboveTheirVehicle) {
  const View view = top_view({0, 0}, 400.0, 0.0, 50.0, 400, 300);  // 0.75 px a meter
  PictureScene picture;
  picture.states.resize(1);
  const std::vector<std::string> names = {"uav"};
  const auto drawn = [&](float text_px, float radius_m, float min_px, bool captions, float line_scale) {
    Look look;
    look.text_px = text_px;
    look.captions = captions;
    look.line_scale = line_scale;
    auto canvas = std::make_unique<NotedCanvas>(400, 300);
    draw_vehicle_marks(*canvas, look, view, picture, {names, std::vector<float>{radius_m}, min_px});
    return canvas;
  };
  for (const float line_scale : {1.0F, 1.5F}) {
    for (const float text_px : {10.0F, 20.0F}) {
      const auto canvas = drawn(text_px, 1.0F, 40.0F, true, line_scale);
      ASSERT_EQ(canvas->rings.size(), 2U);
      const float width = std::max(2.0F, 0.153F * text_px) * line_scale;
      EXPECT_NEAR(canvas->ring_widths[1], width, 0.2F * width);
      EXPECT_NEAR(canvas->ring_widths[0], 2.2F * width, 0.45F * width) << "as a rim";
      EXPECT_EQ(canvas->colors[0], Look{}.halo);
      EXPECT_EQ(canvas->colors[1], vehicle_color(0));
      EXPECT_EQ(canvas->rings[0].z(), 20.0F);
      // A small ring is not filled by its own stroke.
      EXPECT_NEAR(drawn(text_px, 1.0F, 10.0F, true, line_scale)->ring_widths[1], 1.5F, 0.3F);
    }
  }
  for (const float radius_m : {4.0F, 30.0F, 300.0F}) {
    const auto canvas = drawn(10.0F, radius_m, 0.0F, true, 1.0F);
    EXPECT_TRUE(canvas->rings.empty());
    const float lift = 150.0F - canvas->texts.at(0).at_px.y();
    const float expected = std::min(0.9F * 0.75F * radius_m + 9.0F, 60.0F);  // a fifth of the picture at most
    EXPECT_NEAR(lift, expected, 0.15F * expected) << radius_m;
    EXPECT_EQ(canvas->texts[0].at_px.x(), 200.0F);
    EXPECT_NEAR(canvas->texts[0].style.height_px, 9.0F, 2.0F);
  }
  // Lighter than the vehicle on a dark rim, darker on paper.
  const Rgb light = drawn(10.0F, 1.0F, 0.0F, true, 1.0F)->texts.at(0).style.color;
  const Rgb dark = drawn(10.0F, 1.0F, 0.0F, false, 1.0F)->texts.at(0).style.color;
  EXPECT_LE(light.maxCoeff(), 1.0F);
  for (int c = 0; c < 3; ++c) {
    EXPECT_GT(light[c], vehicle_color(0)[c] + 0.01F);
    EXPECT_NEAR(light[c], 0.75F * vehicle_color(0)[c] + 0.25F, 0.08F);
    EXPECT_NEAR(dark[c], 0.7F * vehicle_color(0)[c], 0.12F * vehicle_color(0)[c] + 0.02F);
  }
}

TEST(VehicleMarks, AreLeftOutBeyondTheEdgesOfThePicture) {
  const View view = top_view({0, 0}, 300.0, 0.0, 50.0, 400, 300);  // a pixel a meter
  const std::vector<std::string> names = {"uav"};
  for (const auto& [x, y, shown] : {std::tuple(199.0, 0.0, true),
                                    {201.0, 0.0, false},
                                    {-199.0, 0.0, true},
                                    {-201.0, 0.0, false},
                                    {0.0, 149.0, true},
                                    {0.0, 151.0, false},
                                    {0.0, -149.0, true},
                                    {0.0, -151.0, false},
                                    {200.0, 150.0, true}}) {
    PictureScene picture;
    picture.states.resize(1);
    picture.states[0].p_world_m = {x, y, 3.0};
    NotedCanvas canvas(400, 300);
    draw_vehicle_marks(canvas, {}, view, picture, {names, {}, 12.0F});
    EXPECT_EQ(canvas.texts.size(), shown ? 1U : 0U) << x << " " << y;
    EXPECT_EQ(canvas.rings.size(), shown ? 2U : 0U) << "0.35 m where no radius is known";
  }
  // Of which no radius is known, one of 0.35 m.
  PictureScene picture;
  picture.states.resize(1);
  for (const double px_per_m : {16.5, 18.0}) {
    NotedCanvas canvas(400, 300);
    const View near = top_view({0, 0}, 300.0 / px_per_m, 0.0, 50.0, 400, 300);
    draw_vehicle_marks(canvas, {}, near, picture, {names, {}, 12.0F});
    EXPECT_EQ(canvas.rings.size(), px_per_m < 17.0 ? 2U : 0U);
  }
  PictureScene swarm;
  swarm.states.resize(25);
  NotedCanvas canvas(400, 300);
  draw_vehicle_marks(canvas, {}, view, swarm, {std::vector<std::string>(25, "uav"), {}, 0.0F});
  EXPECT_TRUE(canvas.texts.empty()) << "more than 24 names would cover the picture";
}

TEST(Captions, NiceNumbersAreOneTwoAndFive) {
  for (const double power : {1e-3, 1.0, 1e4}) {
    for (const auto& [x, nice] : {std::pair(1.0, 1.0), {1.999, 1.0}, {2.0, 2.0}, {4.999, 2.0}, {5.0, 5.0}, {9.99, 5.0}})
      EXPECT_NEAR(round_down_nicely(x * power), nice * power, 1e-9 * power) << x << " " << power;
  }
  EXPECT_EQ(round_down_nicely(2.0 * (1.0 - 1e-10)), 2.0) << "what is meant to be round";
  EXPECT_EQ(tick_text(0.3, 0.1), "0.3");
  EXPECT_EQ(tick_text(0.25, 0.05), "0.25");
  EXPECT_EQ(tick_text(7.0, 1.0), "7");
  EXPECT_EQ(tick_text(-0.0, 1.0), "0");
  EXPECT_EQ(tick_text(3000.0, 1000.0), "3000");
}

TEST(Sidebar, IsAsWideAsItsWidestLineInTheWidestFont) {
  Look look;
  look.text_px = 20.0F;
  const float h = 17.0F;  // 0.85 of the text on the picture
  const auto room = [&](const std::string& text) { return 1.16F * text_width_px(text, h); };
  const Sidebar one{{{"occupied", {1, 0, 0, 1}}, {"free", {0, 1, 0, 1}}}, {}};
  EXPECT_NEAR(sidebar_width_px(one, look), room("occupied") + (2.9F + 0.8F) * h, 1.5F);
  const Sidebar bar{{}, ColorBar{turbo_like, 0.0, 40.0, "z [m]"}};
  EXPECT_NEAR(sidebar_width_px(bar, look), (1.3F + 0.9F + 2.0F) * h + room("-88.8"), 1.5F);
  const Sidebar large{{}, ColorBar{turbo_like, 0.0, 4000000.0, "z [m]"}};
  EXPECT_NEAR(sidebar_width_px(large, look), (1.3F + 0.9F + 2.0F) * h + room("4000000"), 1.5F);
  const Sidebar unit{{}, ColorBar{turbo_like, 0.0, 40.0, "reflectivity in parts of white"}};
  EXPECT_NEAR(sidebar_width_px(unit, look), 2.0F * h + room("reflectivity in parts of white"), 1.5F);
}

TEST(Sidebar, BreaksMeaningsAtBlanksWhereTheyAreWiderThanFourteenLetters) {
  Look look;
  const float h = 0.85F * look.text_px, widest = 14.0F * h;
  const Sidebar sidebar{{{"a meaning that is told at such a length that no line of a margin holds it", {1, 0, 0, 1}},
                         {"onelongwordthatnobodycouldbreakwhereverhewantedto it", {1, 0, 0, 1}},
                         {"two words", {1, 0, 0, 1}}},
                        {}};
  const SidebarLayout layout = lay_out(sidebar, look, {0, 0, 400, 2000});
  ASSERT_EQ(layout.rows.size(), 3U);
  std::string joined;
  const std::vector<std::string>& lines = layout.rows[0].lines;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    joined += (i > 0 ? " " : "") + lines[i];
    EXPECT_LE(kWidestFont * text_width_px(lines[i], h), widest);
    if (i + 1 < lines.size()) {
      const std::string longer = lines[i] + " " + lines[i + 1].substr(0, lines[i + 1].find(' '));
      EXPECT_GT(kWidestFont * text_width_px(longer, h), widest) << "no word finds room on the line before";
    }
  }
  EXPECT_EQ(joined, sidebar.keys[0].meaning);
  EXPECT_EQ(layout.rows[1].lines,
            (std::vector<std::string>{"onelongwordthatnobodycouldbreakwhereverhewantedto", "it"}));
  EXPECT_EQ(layout.rows[2].lines, (std::vector<std::string>{"two words"}));
}

TEST(Sidebar, RowsFollowEachOtherWithTheirSwatchBesideTheFirstLine) {
  Look look;
  look.text_px = 20.0F;
  const float h = 17.0F;
  const Sidebar sidebar = full_sidebar(3);
  const Box margin{100.0F, 50.0F, 300.0F, 900.0F};
  const SidebarLayout layout = lay_out(sidebar, look, margin);
  EXPECT_FLOAT_EQ(layout.text_px, h);
  EXPECT_NEAR(layout.line_px, 1.6F * h, 0.25F * h);
  EXPECT_NEAR(layout.text_left_px, 100.0F + 2.9F * h, 0.4F * h);
  ASSERT_EQ(layout.rows.size(), 4U);
  EXPECT_EQ(layout.left_out, 0U);
  float top = 50.0F + h;
  for (const SidebarLayout::Row& row : layout.rows) {
    EXPECT_NEAR(row.swatch.top, top, 0.3F * h);
    EXPECT_NEAR(row.swatch.left, 100.0F + h, 0.3F * h);
    EXPECT_NEAR(row.swatch.width, 1.2F * h, 0.3F * h);
    EXPECT_EQ(row.swatch.height, row.swatch.width);
    EXPECT_LT(row.swatch.right() + 0.3F * h, layout.text_left_px);
    // A capital lies in the middle of the swatch.
    const float middle = row.first_baseline_px - 0.5F * h;
    EXPECT_NEAR(middle, row.swatch.top + 0.5F * row.swatch.height, 0.15F * h);
    top = row.swatch.top + layout.line_px * static_cast<float>(row.lines.size()) + 0.4F * h;
  }
  EXPECT_EQ(layout.rows[3].color, Rgb(1, 0, 0));
  EXPECT_NEAR(layout.rows[1].swatch.top - layout.rows[0].swatch.top, 2.0F * h, 0.15F * h);
}

// As many rows as leave room for a line that counts the rest, for the bar and for a margin.
TEST(Sidebar, ShowsAsManyKeysAsFindRoom) {
  Look look;
  look.text_px = 20.0F;
  const float h = 17.0F;
  for (const bool with_bar : {false, true}) {
    Sidebar sidebar;
    for (int i = 0; i < 6; ++i) sidebar.keys.push_back({"meaning " + std::to_string(i), {0.1F, 0.2F, 0.3F, 1.0F}});
    if (with_bar) sidebar.bar = ColorBar{turbo_like, 0.0, 10.0, "z [m]"};
    for (std::size_t rows = 1; rows <= 6; ++rows) {
      // Rows of 2 h after a margin of h; the last one needs no gap below it.
      const float rest = rows < 6 ? 1.6F * h : 0.0F;
      const float needed =
          h + 2.0F * h * static_cast<float>(rows) - 0.4F * h + rest + (with_bar ? 11.0F * h : 0.0F) + 0.6F * h;
      for (const float more : {-0.12F * h, 0.12F * h}) {
        const SidebarLayout layout = lay_out(sidebar, look, {0, 0, 300, needed + more});
        EXPECT_EQ(layout.rows.size(), more > 0.0F ? rows : rows - 1) << rows << with_bar;
        EXPECT_EQ(layout.left_out, 6 - layout.rows.size());
        if (layout.left_out > 0 && !layout.rows.empty()) {
          const float baseline = layout.rows.back().first_baseline_px + 2.0F * h;  // as another row
          EXPECT_NEAR(layout.left_out_baseline_px, baseline, 0.15F * h);
        }
      }
    }
  }
}

TEST(Sidebar, BarIsNearlyHalfAsHighAsTheMarginWithItsUnitAboveIt) {
  Look look;
  look.text_px = 20.0F;
  const float h = 17.0F;
  for (const float height : {100.0F, 240.0F, 400.0F, 900.0F}) {
    const Sidebar sidebar{{}, ColorBar{turbo_like, 0.0, 10.0, "z [m]"}};
    const SidebarLayout layout = lay_out(sidebar, look, {40, 30, 300, height});
    EXPECT_NEAR(layout.bar.left, 40.0F + h, 0.3F * h);
    EXPECT_NEAR(layout.bar.width, 1.3F * h, 0.3F * h);
    EXPECT_NEAR(layout.bar.top - layout.unit_baseline_px, 1.6F * h, 0.3F * h);
    const float room = height - h - 1.2F * h - 4.2F * h;
    const float expected = std::clamp(0.45F * height, 4.0F * h, std::max(4.0F * h, room));
    EXPECT_NEAR(layout.bar.height, expected, 0.05F * expected) << height;
    if (height < 200.0F) continue;
    const float above = layout.unit_baseline_px - h - 30.0F, below = 30.0F + height - layout.bar.bottom();
    EXPECT_NEAR(above, below, 1.5F * h) << "in the middle";
    EXPECT_GE(above, 0.0F);
  }
  // Below the keys it stands close to them.
  const SidebarLayout under = lay_out(full_sidebar(3), look, {0, 0, 300, 900});
  const float end = under.rows.back().swatch.top + under.line_px * static_cast<float>(under.rows.back().lines.size());
  EXPECT_NEAR(under.unit_baseline_px - end, 2.0F * h, 0.4F * h);
  EXPECT_NEAR(under.bar.height, 0.45F * 900.0F, 1.0F);
  const SidebarLayout tight = lay_out(full_sidebar(9), look, {0, 0, 300, 700});
  EXPECT_LE(tight.bar.bottom(), 700.0F - 1.0F * h);
  EXPECT_GE(tight.bar.bottom(), 700.0F - 2.5F * h);
}

TEST(Sidebar, TicksAreAtRoundNumbersAboutFourOfThemAndFartherApartThanTheirText) {
  Look look;
  look.text_px = 20.0F;
  const float h = 17.0F;
  const auto layout_of = [&](double low, double high, float height) {
    return lay_out({{}, ColorBar{turbo_like, low, high, "z [m]"}}, look, {0, 0, 300, height});
  };
  EXPECT_EQ(layout_of(0.0, 10.0, 900).tick_step, 2.0);
  EXPECT_EQ(layout_of(0.0, 8.0, 900).ticks, (std::vector<double>{0, 2, 4, 6, 8}));
  EXPECT_EQ(layout_of(-3.0, 17.5, 900).ticks, (std::vector<double>{0, 5, 10, 15}));
  EXPECT_EQ(layout_of(-5.0, 15.0, 900).ticks, (std::vector<double>{-5, 0, 5, 10, 15})) << "both ends count";
  EXPECT_EQ(layout_of(3.0, 3.0, 900).ticks.size(), 1U) << "a scale without extent";
  for (float height = 120.0F; height < 500.0F; height += 13.0F) {
    const SidebarLayout layout = layout_of(0.0, 10.0, height);
    const double apart_px = layout.tick_step / 10.0 * layout.bar.height;
    EXPECT_GE(apart_px, 2.2 * h);
    const double finer = layout.tick_step == 5.0 ? 2.0 : layout.tick_step == 10.0 ? 5.0 : 0.0;
    if (finer > 0.0) {
      EXPECT_LT(finer / 10.0 * layout.bar.height, 2.2 * h + 0.5) << height;
    }
  }
}

TEST(Sidebar, BarShowsItsColorsFromHighToLowAndItsTicksAtTheirValues) {
  Look look;
  look.text_px = 20.0F;
  const float h = 17.0F;
  for (const int height : {130, 260, 900}) {
    const auto gray = [](float s) { return Rgb::Constant(s); };
    const Sidebar sidebar{{}, ColorBar{gray, -4.0, 16.0, "z [m]"}};
    NotedCanvas canvas(300, height);
    draw_sidebar(canvas, look, sidebar, 100);
    const SidebarLayout layout = lay_out(sidebar, look, {100, 0, 200, static_cast<float>(height)});
    EXPECT_EQ(canvas.rectangles[0].left, 100.0F);
    EXPECT_EQ(canvas.rectangles[0].width, 200.0F);
    EXPECT_EQ(canvas.rectangles[0].height, static_cast<float>(height));
    EXPECT_EQ(canvas.colors[0], look.page);
    std::size_t steps = 0;
    float end = layout.bar.top;
    for (std::size_t i = 1; i < canvas.rectangles.size(); ++i) {
      const Box& box = canvas.rectangles[i];
      if (box.left != layout.bar.left) continue;
      EXPECT_LE(box.top, end + 1e-3F) << "no seam";
      const float value = 1.0F - (box.top - layout.bar.top) / layout.bar.height;
      EXPECT_LT(canvas.colors[i].x(), value + 1e-4F);
      EXPECT_GT(canvas.colors[i].x(), value - 0.07F);
      EXPECT_LE(box.bottom(), layout.bar.bottom() + 1e-3F);
      EXPECT_LE(box.height, layout.bar.height / 16.0F + 1.0F);
      end = box.bottom();
      ++steps;
    }
    EXPECT_NEAR(end, layout.bar.bottom(), 1e-2F);
    EXPECT_EQ(steps, static_cast<std::size_t>(std::clamp(static_cast<int>(layout.bar.height), 16, 128)));
    for (const double tick : layout.ticks) {
      const float y = layout.bar.bottom() - static_cast<float>((tick + 4.0) / 20.0) * layout.bar.height;
      const auto text = std::find_if(canvas.texts.begin(), canvas.texts.end(),
                                     [&](const auto& t) { return t.content == tick_text(tick, layout.tick_step); });
      ASSERT_NE(text, canvas.texts.end()) << tick;
      EXPECT_NEAR(text->at_px.y() - 0.5F * h, y, 0.1F * h) << "centered beside it";
      EXPECT_NEAR(text->at_px.x(), layout.bar.right() + 0.9F * h, 0.2F * h);
      EXPECT_NEAR(text->style.height_px, h, 0.01F);
      EXPECT_EQ(text->style.halo_alpha, 0.0F);
      const auto mark = std::find_if(canvas.rectangles.begin(), canvas.rectangles.end(), [&](const Box& box) {
        return box.left == layout.bar.right() && std::abs(box.top + 0.5F * box.height - y) < 0.1F;
      });
      ASSERT_NE(mark, canvas.rectangles.end()) << tick;
      EXPECT_NEAR(mark->width, 0.5F * h, 0.2F * h);
      EXPECT_NEAR(mark->height, 1.53F, 0.4F);
    }
    EXPECT_EQ(canvas.texts.front().content, "z [m]");
    EXPECT_EQ(canvas.texts.front().at_px.x(), layout.bar.left);
    EXPECT_EQ(canvas.texts.front().at_px.y(), layout.unit_baseline_px);
  }
  NotedCanvas none(100, 50);
  draw_sidebar(none, look, full_sidebar(2), 100);
  EXPECT_TRUE(none.rectangles.empty()) << "no margin, nothing in it";
}

TEST(DepthPicture, ScaleHoldsNineOfTenPixelsUpToARoundNumber) {
  DepthImage depth{100, 10, std::vector<float>(1000, 0.0F)};
  for (int i = 0; i < 1000; ++i) depth.depth_m[i] = 0.01F * static_cast<float>(i + 1);  // up to 10 m
  // 92 in a hundred are nearer than 9.2 m: steps of 2 m, up to 10 m.
  EXPECT_DOUBLE_EQ(depth_scale_end_m(depth), 10.0);
  for (float& d : depth.depth_m) d *= 0.85F;  // 7.82 m: steps of 1 m
  EXPECT_DOUBLE_EQ(depth_scale_end_m(depth), 8.0);
  for (float& d : depth.depth_m) d *= 1.05F;  // 8.2 m: steps of 2 m
  EXPECT_DOUBLE_EQ(depth_scale_end_m(depth), 10.0);
  depth.depth_m.assign(1000, 0.3F);  // 0.1 m is the finest step
  EXPECT_NEAR(depth_scale_end_m(depth), 0.35, 0.06);
  depth.depth_m.assign(1000, 0.0F);
  EXPECT_DOUBLE_EQ(depth_scale_end_m(depth), 10.0) << "nothing is seen";
  for (int i = 0; i < 1000; ++i) depth.depth_m[i] = i < 905 ? 1.0F : 50.0F;
  EXPECT_GT(depth_scale_end_m(depth), 40.0);
  for (int i = 0; i < 1000; ++i) depth.depth_m[i] = i < 935 ? 1.0F : 50.0F;
  EXPECT_LT(depth_scale_end_m(depth), 2.0);
}

}  // namespace
}  // namespace swiftlet::sim
