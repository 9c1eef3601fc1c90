// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/captions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

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

TEST(Legend, ShowsEachMeaningOnceInItsColor) {
  const Overlay::Key red{"flying", {1.0F, 0.0F, 0.0F, 0.3F}}, blue{"background", {0.0F, 0.0F, 1.0F, 1.0F}};
  Image once(640, 360, Rgb::Constant(0.5F)), twice = once;
  draw_legend(once, std::vector{red, blue});
  draw_legend(twice, std::vector{red, blue, red});
  EXPECT_EQ(once.rgb, twice.rgb);
  EXPECT_GT(pixels_of(once, {1.0F, 0.0F, 0.0F}), 30);
  EXPECT_EQ(pixels_of(once, {1.0F, 0.0F, 0.0F}), pixels_of(once, {0.0F, 0.0F, 1.0F}));
}

TEST(Legend, IsNotThereWithoutKeys) {
  Image image(640, 360, Rgb::Constant(0.5F));
  const Image before = image;
  draw_legend(image, {});
  EXPECT_EQ(image.rgb, before.rgb);
}

TEST(ScaleBar, IsAsLongAsItsRoundNumberOfMeters) {
  for (const double span_m : {30.0, 70.0, 400.0}) {
    const View view = top_view({0, 0}, span_m, 0.0, 10.0, 640, 360);
    Image image(640, 360, Rgb::Constant(0.5F));
    draw_scale_bar(image, view);
    // The first half is gray, the second white.
    int white = 0, gray = 0;
    for (int y = 0; y < image.height; ++y) {
      int white_here = 0, gray_here = 0;
      for (int x = 0; x < image.width; ++x) {
        const int shade = image.pixel(x, y)[0];
        white_here += shade == 255;
        gray_here += std::abs(shade - 64) <= 1;
      }
      if (gray_here > gray) gray = gray_here, white = white_here;
    }
    const double length_m = (white + gray) / view.pixels_per_m(1.0);
    EXPECT_NEAR(length_m, round_down_nicely(0.2 * 640 / view.pixels_per_m(1.0)), 1.0 / view.pixels_per_m(1.0));
    EXPECT_NEAR(white, gray, 1);
  }
}

TEST(Names, OfATeamAreWrittenAboveItsVehiclesAndOfASwarmNot) {
  const View view = top_view({0, 0}, 40.0, 0.0, 10.0, 640, 360);
  for (const int count : {1, 10, 24, 100}) {
    PictureScene picture;
    picture.states.resize(static_cast<std::size_t>(count));
    const std::vector<std::string> names(static_cast<std::size_t>(count), "uav");
    Image image(640, 360, Rgb::Constant(0.5F));
    const Image before = image;
    draw_names(image, view, picture, names, 1.0);
    EXPECT_EQ(image.rgb != before.rgb, count <= 24) << count;
  }
}

}  // namespace
}  // namespace swiftlet::sim
