// SPDX-License-Identifier: BSD-3-Clause
// Pixels of small drawings, each one computed a second time by its distance from what is drawn.
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
using testing::HasSubstr;

float distance_to(const Vector2f& p, const Vector2f& a, const Vector2f& b) {
  const Vector2f ab = b - a;
  const float along =
      ab.squaredNorm() > 0.0F ? std::min(1.0F, std::max(0.0F, (p - a).dot(ab) / ab.squaredNorm())) : 0.0F;
  return (p - a - along * ab).norm();
}

/// Lays a color over a picture of real numbers.
void lay(Rgb& pixel, const Rgb& color, float alpha) { pixel = (1.0F - alpha) * pixel + alpha * color; }

void expect_pixels(const Image& image, const std::function<Rgb(int, int)>& expected, float most = 1.6F) {
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Rgb wanted = 255.0F * expected(x, y);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(image.pixel(x, y)[c], wanted[c], most) << x << " " << y << " " << c;
    }
  }
}

TEST(Image, PixelsAreRoundedBytesAndClippedAtTheEdges) {
  Image image(5, 4, Rgb(0.0F, 0.5F, 2.0F));
  EXPECT_EQ(image.rgb.size(), 60U);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 5; ++x) {
      EXPECT_EQ(image.pixel(x, y)[0], 0);
      EXPECT_EQ(image.pixel(x, y)[1], 128);
      EXPECT_EQ(image.pixel(x, y)[2], 255);
    }
  }
  const std::vector<std::uint8_t> before = image.rgb;
  for (const auto& [x, y] : {std::pair(-1, 0), {0, -1}, {5, 0}, {0, 4}}) {
    set_pixel(image, x, y, Rgb::Ones());
    blend_pixel(image, x, y, Rgb::Ones(), 1.0F);
  }
  EXPECT_EQ(image.rgb, before);
  set_pixel(image, 4, 3, Rgb(0.2F, -1.0F, 0.499F / 255.0F));
  EXPECT_EQ(image.pixel(4, 3)[0], 51);
  EXPECT_EQ(image.pixel(4, 3)[1], 0);
  EXPECT_EQ(image.pixel(4, 3)[2], 0);
  blend_pixel(image, 0, 0, Rgb(1.0F, 1.0F, 0.0F), 0.25F);
  EXPECT_EQ(image.pixel(0, 0)[0], 64);
  EXPECT_EQ(image.pixel(0, 0)[1], 160);
  EXPECT_EQ(image.pixel(0, 0)[2], 191);
}

TEST(Image, RectanglesCoverTheirPixelsAndNoOthers) {
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

TEST(Canvas, OfPixelsRoundsRectanglesToWholePixelsOfWhichOneIsLeast) {
  const auto covered = [](const Box& box) {
    Image image(20, 20, Rgb::Zero());
    PixelCanvas(image).rectangle(box, Rgb::Ones(), 1.0F);
    int left = 99, right = -1, top = 99, bottom = -1;
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 20; ++x) {
        if (image.pixel(x, y)[0] == 0) continue;
        left = std::min(left, x), right = std::max(right, x), top = std::min(top, y), bottom = std::max(bottom, y);
      }
    }
    return std::array{left, top, right, bottom};
  };
  EXPECT_EQ(covered({3.4F, 5.6F, 4.0F, 2.0F}), (std::array{3, 6, 6, 7}));
  EXPECT_EQ(covered({3.4F, 5.4F, 0.05F, 0.0F}), (std::array{3, 5, 3, 5})) << "a thin line is still a line";
  EXPECT_EQ(covered({2.6F, 2.6F, 1.0F, 3.3F}), (std::array{3, 3, 3, 5}));
}

// Anti-aliased: ink fades over one pixel at the edge of the stroke.
TEST(Canvas, OfPixelsDrawsLinesAndRingsByTheDistanceOfEachPixel) {
  const Random random(2, "test.strokes");
  for (std::uint32_t i = 0; i < 40; ++i) {
    const auto draw = [&](double low, double high, std::uint32_t k) {
      return static_cast<float>(random.uniform(low, high, i, k));
    };
    const Vector2f a(draw(-5, 35, 0), draw(-5, 25, 1)), b = i % 5 == 0 ? a : Vector2f(draw(-5, 35, 2), draw(-5, 25, 3));
    const float width = draw(0.5, 7.0, 4), radius = draw(0.0, 14.0, 5);
    const Rgb color(1.0F, 0.3F, 0.0F);
    Image line(30, 20, Rgb::Constant(0.1F)), ring(30, 20, Rgb::Constant(0.1F));
    PixelCanvas(line).line(a, b, width, color);
    PixelCanvas(ring).ring(a, radius, width, color);
    const auto ink = [&](float d) {
      Rgb pixel = Rgb::Constant(0.1F);
      lay(pixel, color, std::min(1.0F, std::max(0.0F, 0.5F * width + 0.5F - d)));
      return pixel;
    };
    const auto center = [](int x, int y) {
      return Vector2f(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
    };
    expect_pixels(line, [&](int x, int y) { return ink(distance_to(center(x, y), a, b)); });
    expect_pixels(ring, [&](int x, int y) { return ink(std::abs((center(x, y) - a).norm() - radius)); });
  }
}

TEST(Canvas, OfPixelsTakesThePartOfAPictureThatLiesOnIt) {
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

TEST(Canvas, OfSvgHasTheSameMeasuresAsText) {
  SvgCanvas canvas(200, 100, 254.0, "");
  canvas.rectangle({1, 2, 30, 4}, Rgb(1.0F, 0.5F, 0.0F), 0.25F);
  canvas.rectangle({1, 2, 30, 5}, Rgb(2.0F, -1.0F, 0.2F), 1.0F);
  canvas.line({1, 2}, {3, 4}, 2.5F, Rgb::Zero());
  canvas.ring({10, 20}, 5.0F, 1.5F, Rgb::Ones());
  canvas.picture(7, 8, Image(3, 2));
  canvas.picture(9, 9, Image());
  canvas.text({5, 6}, "left", {.height_px = 7.29F, .align = Align::kLeft, .halo_alpha = 0.0F});
  canvas.text({5, 6}, "middle", {.height_px = 7.29F, .align = Align::kCenter, .halo_alpha = 0.5F});
  const std::string svg = canvas.finish();
  EXPECT_THAT(svg, HasSubstr("width=\"20mm\" height=\"10mm\""));
  EXPECT_THAT(svg,
              HasSubstr("<rect x=\"1\" y=\"2\" width=\"30\" height=\"4\" fill=\"#ff8000\" fill-opacity=\"0.25\"/>"));
  EXPECT_THAT(svg, HasSubstr("<rect x=\"1\" y=\"2\" width=\"30\" height=\"5\" fill=\"#ff0033\"/>"));
  EXPECT_THAT(svg, HasSubstr("d=\"M1,2L3,4\" stroke=\"#000000\" stroke-width=\"2.5\""));
  EXPECT_THAT(svg,
              HasSubstr("<circle cx=\"10\" cy=\"20\" r=\"5\" fill=\"none\" stroke=\"#ffffff\" stroke-width=\"1.5\"/>"));
  EXPECT_THAT(svg, HasSubstr("<image x=\"7\" y=\"8\" width=\"3\" height=\"2\""));
  EXPECT_THAT(svg, testing::Not(HasSubstr("<image x=\"9\"")));
  // A capital of DejaVu Sans is 0.729 of the size of the font; the halo reaches about a seventh of it beyond.
  EXPECT_THAT(svg, HasSubstr("font-size=\"10\" fill="));
  const std::size_t left = svg.find(">left<"), middle = svg.find(">middle<");
  EXPECT_EQ(svg.substr(svg.rfind("<text", left), left - svg.rfind("<text", left)).find("stroke"), std::string::npos);
  const std::string halo = svg.substr(svg.rfind("<text", middle), middle - svg.rfind("<text", middle));
  EXPECT_THAT(halo, HasSubstr("text-anchor=\"middle\""));
  EXPECT_THAT(halo, HasSubstr("stroke-opacity=\"0.50\""));
  const double width = std::stod(halo.substr(halo.find("stroke-width=\"") + 14));
  EXPECT_NEAR(width, 2.1, 0.5);
}

// ---- Colors.

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

TEST(Colors, OfDistancesGoRoundTheRainbowInEvenSteps) {
  const auto hue_deg = [](const Rgb& c) {
    const float most = c.maxCoeff(), extent = most - c.minCoeff();
    if (c.x() == most) return 60.0F * (c.y() - c.z()) / extent;
    return c.y() == most ? 120.0F + 60.0F * (c.z() - c.x()) / extent : 240.0F + 60.0F * (c.x() - c.y()) / extent;
  };
  float before = hue_deg(turbo_like(0.06F));
  for (float s = 0.06F; s < 0.98F; s += 0.01F) {
    const float hue = hue_deg(turbo_like(s));
    EXPECT_LT(hue, before + 12.0F) << s;
    EXPECT_GT(hue, before - 14.0F) << s;
    before = hue;
    EXPECT_LT((turbo_like(s) - turbo_like(s + 0.01F)).norm(), 0.07F) << "no jump";
  }
  EXPECT_GT(hue_deg(turbo_like(0.1F)), 200.0F);
  EXPECT_NEAR(hue_deg(turbo_like(0.5F)), 95.0F, 25.0F);
  EXPECT_NEAR(hue_deg(turbo_like(0.95F)), 10.0F, 10.0F);
  EXPECT_LT(turbo_like(0.0F).maxCoeff(), 0.3F) << "dark at both ends";
  EXPECT_LT(turbo_like(1.0F).maxCoeff(), 0.55F);
  // Heights leave out the dark ends.
  EXPECT_LT((height_color(0.0F) - turbo_like(0.14F)).norm(), 1e-5F);
  EXPECT_LT((height_color(1.0F) - turbo_like(0.86F)).norm(), 1e-4F);
  EXPECT_LT((height_color(0.5F) - turbo_like(0.5F)).norm(), 1e-4F);
  EXPECT_EQ(height_color(-3.0F), height_color(0.0F));
  EXPECT_EQ(height_color(3.0F), height_color(1.0F));
}

TEST(Colors, OfNoSurfaceIsGray) {
  const Rgb none = class_color(9999);
  EXPECT_EQ(none, class_color(0));
  EXPECT_LT(none.maxCoeff() - none.minCoeff(), 0.02F);
}

/// Hues by the golden ratio, of one lightness: as HSV to RGB is computed by hand.
TEST(Colors, OfTheEleventhVehicleOnGoRoundTheWheelByTheGoldenRatio) {
  for (VehicleId vehicle = 10; vehicle < 60; ++vehicle) {
    const double turn = std::fmod(vehicle * (std::sqrt(5.0) - 1.0) / 2.0, 1.0);
    const Rgb color = vehicle_color(vehicle);
    // One channel falls and one rises as the wheel turns; which one is told by the sixth of it.
    const double h = std::fmod(6.0 * turn + 1.0, 6.0);
    const int sixth = static_cast<int>(h);
    const double f = h - sixth, high = 0.92, low = 0.20, up = low + 0.72 * f, down = high - 0.72 * f;
    const double wheel[6][3] = {{high, up, low},   {down, high, low}, {low, high, up},
                                {low, down, high}, {up, low, high},   {high, low, down}};
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(color[c], wheel[sixth][c], 1e-4) << vehicle << " " << c;
  }
  EXPECT_EQ(vehicle_color(-5), vehicle_color(0));
  EXPECT_TRUE(is_dominated_by(vehicle_color(0), 0));
  EXPECT_TRUE(is_dominated_by(vehicle_color(1), 2));
}

TEST(Colors, OfPartsShowWhoseTheyAre) {
  VehicleShape shape;
  shape.materials.push_back({"frame", 0.3F, false, {0.1F, 0.2F, 0.8F}});
  Mesh mesh;
  const auto color = [&](VehiclePart part) {
    mesh.part = part;
    return part_color(shape, mesh, 3);
  };
  EXPECT_EQ(color(VehiclePart::kBody), vehicle_color(3));
  EXPECT_LT((color(VehiclePart::kArm) - (0.75F * vehicle_color(3) + 0.25F * Rgb(0.1F, 0.2F, 0.8F))).norm(), 1e-5F);
  EXPECT_LT(color(VehiclePart::kMotor).maxCoeff(), 0.21F);
  EXPECT_GT(color(VehiclePart::kMotor).minCoeff(), 0.12F);
  EXPECT_EQ(color(VehiclePart::kLeg), Rgb(0.1F, 0.2F, 0.8F));
  mesh.material = 1;  // there is none
  EXPECT_EQ(color(VehiclePart::kLeg).x(), color(VehiclePart::kLeg).z());
  EXPECT_NEAR(color(VehiclePart::kLeg).x(), 0.3F, 0.1F);
}

TEST(Colors, BecomeLinearAsTheStandardSays) {
  // IEC 61966-2-1: a straight piece, then the power of 2.4.
  for (const float s : {0.0F, 0.02F, 0.0404F, 0.0405F, 0.1F, 0.5F, 1.0F}) {
    const double expected = s <= 0.04045F ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(to_linear(Rgb::Constant(s)).x(), expected, 1e-6) << s;
  }
  EXPECT_NEAR(to_linear(Rgb(0.2F, 0.5F, 0.7F)).y(), 0.21404, 1e-4);
}

// ---- Lines as wide as told, in pixels.

View ten_px_a_meter() { return top_view({0, 0}, 30.0, 0.0, 10.0, 400, 300); }

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

TEST(WideLines, CornersReachOutwardByTheMiterUpToTwiceTheWidth) {
  const View view = ten_px_a_meter();
  const std::vector<Vector4f> red = {{1, 0, 0, 1}};
  for (const double turn_deg : {10.0, 60.0, 90.0, 110.0, 130.0, 160.0, 165.0}) {
    const double turn = turn_deg * M_PI / 180.0;
    const Vector3f corner(1, 1, 1),
        end = corner + Vector3f(8 * static_cast<float>(std::cos(turn)), 8 * static_cast<float>(std::sin(turn)), 0);
    const auto pixels = pixels_of(view, ribbon(view, {{-5, 1, 1}, corner, end}, red, 6.0F));
    float farthest = 0.0F;
    for (const Vector2f& p : pixels) {
      const Vector2f off = p - Vector2f(10, 10);
      if (off.norm() < 25.0F) farthest = std::max(farthest, off.norm());
    }
    EXPECT_NEAR(farthest, 3.0 * std::min(2.0, 1.0 / std::cos(0.5 * turn)), 0.02) << turn_deg;
  }
  // Where it turns back both ends are square.
  for (const double turn_deg : {170.0, 180.0}) {
    const double turn = turn_deg * M_PI / 180.0;
    const Vector3f corner(1, 1, 1),
        end = corner + Vector3f(8 * static_cast<float>(std::cos(turn)), 8 * static_cast<float>(std::sin(turn)), 0);
    const auto pixels = pixels_of(view, ribbon(view, {{-5, 1, 1}, corner, end}, red, 6.0F));
    EXPECT_EQ(pixels.size(), 18U) << "two rungs at the corner";
    for (const Vector2f& p : pixels) {
      const float off = (p - Vector2f(10, 10)).norm();
      EXPECT_TRUE(off > 25.0F || std::abs(off - 3.0F) < 0.02F) << off;
    }
  }
}

TEST(WideLines, PointsWithinAQuarterOfAPixelAreOne) {
  const View view = ten_px_a_meter();
  const std::vector<Vector4f> red = {{1, 0, 0, 1}};
  EXPECT_EQ(ribbon(view, {{0, 0, 1}, {0.024F, 0, 1}}, red, 3.0F).size(), 0U);
  EXPECT_EQ(ribbon(view, {{0, 0, 1}, {0.026F, 0, 1}}, red, 3.0F).size(), 6U);
  EXPECT_EQ(ribbon(view, {{0, 0, 1}, {0.02F, 0, 1}, {5, 0, 1}}, red, 3.0F).size(), 6U);
  EXPECT_EQ(ribbon(view, {{0, 0, 1}, {1, 0, 1}, {5, 1, 1}}, red, 3.0F).size(), 12U);
}

TEST(WideLines, WidthHoldsAtAnyDistanceAndColorsGoFromEndToEnd) {
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
TEST(WideLines, AreCutBeforeTheEyeWhereTheyPassIt) {
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
