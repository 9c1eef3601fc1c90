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

}  // namespace
}  // namespace swiftlet::sim
