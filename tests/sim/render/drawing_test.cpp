// SPDX-License-Identifier: BSD-3-Clause
// Pixels and colors of small drawings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "render_support.hpp"
#include "sim/render/wide_lines.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
using Eigen::Vector4f;

void expect_pixels(const Image& image, const std::function<Rgb(int, int)>& expected, float most = 1.6F) {
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Rgb wanted = 255.0F * expected(x, y);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(image.pixel(x, y)[c], wanted[c], most) << x << " " << y << " " << c;
    }
  }
}

TEST(Image, FillsExactlyThePixelsOfRectangles) {
  const Random random(1, "test.rectangles");
  for (std::uint32_t i = 0; i < 60; ++i) {
    const auto draw = [&](int low, int high, std::uint32_t k) {
      return static_cast<int>(std::floor(random.uniform(low, high + 1, i, k)));
    };
    const int x0 = draw(-6, 14, 0), y0 = draw(-6, 12, 1), width = draw(0, 12, 2), height = draw(0, 12, 3);
    Image image(12, 9, Rgb::Constant(0.2F));
    blend_rectangle(image, x0, y0, width, height, Rgb(1.0F, 0.0F, 0.6F), 0.5F);
    expect_pixels(image, [&](int x, int y) {
      const bool in = x >= x0 && x < x0 + width && y >= y0 && y < y0 + height;
      return in ? Rgb(0.6F, 0.1F, 0.4F) : Rgb::Constant(0.2F);
    });
  }
}

TEST(Canvas, ClipsPicturesToItsPixels) {
  Image source(7, 5);
  for (std::size_t i = 0; i < source.rgb.size(); ++i) source.rgb[i] = static_cast<std::uint8_t>(50 + i);
  for (const auto& [left, top] :
       {std::pair(0, 0), {-3, -2}, {8, 6}, {-6, 3}, {4, -4}, {-7, 0}, {12, 0}, {0, -5}, {0, 9}}) {
    Image image(12, 9, Rgb::Zero());
    PixelCanvas(image).picture(left, top, source);
    for (int y = 0; y < 9; ++y) {
      for (int x = 0; x < 12; ++x) {
        const bool in = x >= left && x < left + 7 && y >= top && y < top + 5;
        for (int c = 0; c < 3; ++c)
          ASSERT_EQ(image.pixel(x, y)[c], in ? source.pixel(x - left, y - top)[c] : 0) << left << " " << top;
      }
    }
  }
}

// The values that matplotlib publishes, at every eighth.
TEST(Colors, OfIntensitiesAreThoseOfViridis) {
  const int published[9][3] = {{68, 1, 84},    {71, 44, 122}, {59, 82, 139},  {44, 113, 142}, {33, 145, 140},
                               {39, 173, 129}, {94, 201, 98}, {170, 220, 50}, {253, 231, 37}};
  for (int i = 0; i < 9; ++i) {
    const Rgb found = 255.0F * viridis_like(static_cast<float>(i) / 8.0F);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], published[i][c], 1e-2F) << i;
    if (i == 8) continue;
    const Rgb between = viridis_like((static_cast<float>(i) + 0.25F) / 8.0F);
    const Rgb mixed =
        0.75F * viridis_like(static_cast<float>(i) / 8.0F) + 0.25F * viridis_like(static_cast<float>(i + 1) / 8.0F);
    EXPECT_LT((between - mixed).norm(), 1e-4F);
  }
  EXPECT_EQ(viridis_like(-1.0F), viridis_like(0.0F));
  EXPECT_EQ(viridis_like(2.0F), viridis_like(1.0F));
}

TEST(Colors, BecomeLinearAsTheStandardSays) {
  // IEC 61966-2-1: a straight piece, then the power of 2.4.
  for (const float s : {0.0F, 0.02F, 0.0404F, 0.0405F, 0.1F, 0.5F, 1.0F}) {
    const double expected = s <= 0.04045F ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(to_linear(Rgb::Constant(s)).x(), expected, 1e-6) << s;
  }
  EXPECT_NEAR(to_linear(Rgb(0.2F, 0.5F, 0.7F)).y(), 0.21404, 1e-4);
}

std::vector<Vector2f> pixels_of(const View& view, const std::vector<ClipVertex>& vertices) {
  std::vector<Vector2f> pixels;
  for (const ClipVertex& v : vertices) {
    pixels.emplace_back(0.5F * static_cast<float>(view.width_px) * v.clip.x() / v.clip.w(),
                        0.5F * static_cast<float>(view.height_px) * v.clip.y() / v.clip.w());
  }
  return pixels;
}

std::vector<ClipVertex> ribbon(const View& view, const std::vector<Vector3f>& points,
                               const std::vector<Vector4f>& colors, float width) {
  std::vector<ClipVertex> out;
  append_polyline(view, points, colors, width, out);
  return out;
}

TEST(WideLines, KeepWidthAndBlendColors) {
  const View view = perspective_view({0, 0, 0}, {1, 0, 0}, 60.0, 300, 200);
  const std::vector<Vector4f> colors = {{1, 0, 0, 1}, {0, 0, 1, 0.5F}};
  const auto vertices = ribbon(view, {{3, -1, 0}, {40, 8, 2}}, colors, 5.0F);
  ASSERT_EQ(vertices.size(), 6U);
  const auto pixels = pixels_of(view, vertices);
  EXPECT_NEAR((pixels[0] - pixels[1]).norm(), 5.0F, 0.01F);
  EXPECT_NEAR((pixels[2] - pixels[5]).norm(), 5.0F, 0.01F);
  const Eigen::Vector3d a = *view.project({3, -1, 0}), b = *view.project({40, 8, 2});
  const Vector2f middle = 0.5F * (pixels[0] + pixels[1]), end = 0.5F * (pixels[2] + pixels[5]);
  EXPECT_NEAR(middle.x() + 150.0F, a.x(), 0.01);
  EXPECT_NEAR(100.0F - middle.y(), a.y(), 0.01);
  EXPECT_NEAR(end.x() + 150.0F, b.x(), 0.01);
  EXPECT_NEAR(100.0F - end.y(), b.y(), 0.01);
  EXPECT_NEAR((pixels[0] - pixels[1]).dot(end - middle), 0.0F, 0.1F) << "across";
  EXPECT_EQ(vertices[0].color, colors[0]);
  EXPECT_EQ(vertices[2].color, colors[1]);
}

// A line that comes from behind begins just before the eye, in the color that it has there.
TEST(WideLines, AreClippedBeforeTheEye) {
  const View view = perspective_view({0, 0, 0}, {1, 0, 0}, 60.0, 300, 200);
  const std::vector<Vector4f> colors = {{0, 0, 0, 1}, {1, 1, 1, 1}, {0, 1, 0, 1}};
  const auto enters = ribbon(view, {{-1, 0.2F, 0}, {3, 0.2F, 0}}, colors, 4.0F);
  ASSERT_EQ(enters.size(), 6U);
  EXPECT_NEAR(enters[0].clip.w(), 0.05F, 1e-3F);
  EXPECT_GE(enters[0].clip.w(), 0.05F);
  EXPECT_NEAR(enters[0].color.x(), 1.05F / 4.0F, 1e-3F);
  EXPECT_NEAR(enters[2].clip.w(), 3.0F, 1e-4F);
  EXPECT_NEAR(enters[2].color.x(), 1.0F, 1e-4F);
  const auto leaves = ribbon(view, {{3, 0.2F, 0}, {-1, 0.2F, 0}}, colors, 4.0F);
  ASSERT_EQ(leaves.size(), 6U);
  EXPECT_NEAR(leaves[0].clip.w(), 3.0F, 1e-4F);
  EXPECT_NEAR(leaves[2].clip.w(), 0.05F, 1e-3F);
  EXPECT_NEAR(leaves[2].color.x(), 2.95F / 4.0F, 1e-3F);
  // In, out and in again: two pieces.
  const auto pieces = ribbon(view, {{3, 0.2F, 0}, {-1, 0.2F, 0}, {3, -0.2F, 0}}, colors, 4.0F);
  EXPECT_EQ(pieces.size(), 12U);
  for (const ClipVertex& v : pieces) EXPECT_GE(v.clip.w(), 0.05F);
  EXPECT_TRUE(ribbon(view, {{-3, 0, 0}, {-1, 1, 0}}, colors, 4.0F).empty());
  EXPECT_EQ(ribbon(view, {{1, 0, 0}, {0.0505F, 0.01F, 0}}, colors, 4.0F).size(), 6U);
}

}  // namespace
}  // namespace swiftlet::sim
