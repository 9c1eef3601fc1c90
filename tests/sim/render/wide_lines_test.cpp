// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/wide_lines.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace swiftlet::sim {
namespace {

// From the top: a meter is 10 pixels.
View ten_pixels_per_meter() { return top_view({0, 0}, 30.0, 0.0, 10.0, 400, 300); }

double area_px(const View& view, const std::vector<ClipVertex>& triangles) {
  const auto pixel = [&](const ClipVertex& vertex) -> Eigen::Vector2d {
    const Eigen::Vector2f ndc = vertex.clip.head<2>() / vertex.clip.w();
    return {0.5 * view.width_px * ndc.x(), 0.5 * view.height_px * ndc.y()};
  };
  double sum = 0.0;
  for (std::size_t i = 0; i + 2 < triangles.size(); i += 3) {
    const Eigen::Vector2d a = pixel(triangles[i]), b = pixel(triangles[i + 1]) - a, c = pixel(triangles[i + 2]) - a;
    sum += 0.5 * std::abs(b.x() * c.y() - b.y() * c.x());
  }
  return sum;
}

double drawn_px(const std::vector<Eigen::Vector3f>& points_m, float width_px) {
  const View view = ten_pixels_per_meter();
  std::vector<ClipVertex> out;
  append_polyline(view, points_m, std::vector{Eigen::Vector4f(1, 0, 0, 1)}, width_px, out);
  EXPECT_EQ(out.size() % 3, 0U);
  return area_px(view, out);
}

TEST(WideLines, CoverTheirLengthTimesTheirWidth) {
  EXPECT_NEAR(drawn_px({{-5, 0, 1}, {5, 0, 1}}, 3.0F), 100.0 * 3.0, 0.1);
  EXPECT_NEAR(drawn_px({{-5, -3, 1}, {0, 0, 4}, {5, 3, 1}}, 2.0F), 2.0 * 10.0 * std::hypot(10.0, 6.0), 0.1);
}

// The area that a miter adds outside of a corner is removed inside.
TEST(WideLines, CornersOfAnyAngleAreMitred) {
  for (const double turn_deg : {-80.0, -45.0, 20.0, 60.0, 90.0}) {
    const double turn_rad = turn_deg * M_PI / 180.0;
    const Eigen::Vector3f corner(1, 1, 1);
    const Eigen::Vector3f end =
        corner + Eigen::Vector3d(8 * std::cos(turn_rad), 8 * std::sin(turn_rad), 0).cast<float>();
    EXPECT_NEAR(drawn_px({{-5, 1, 1}, corner, end}, 4.0F), 4.0 * (60.0 + 80.0), 1.0) << turn_deg;
  }
}

TEST(WideLines, OmitPointsAndZeroLengths) {
  EXPECT_EQ(drawn_px({{1, 1, 1}}, 4.0F), 0.0);
  EXPECT_EQ(drawn_px({{1, 1, 1}, {1, 1, 1}}, 4.0F), 0.0);
}

// Pieces of a line before the eye, and none from behind it.
TEST(WideLines, AreClippedBeforeTheEye) {
  const View view = perspective_view({0, 0, 0}, {1, 0, 0}, 60.0, 300, 200);
  const auto vertices = [&](const std::vector<Eigen::Vector3f>& points_m) {
    std::vector<ClipVertex> out;
    append_polyline(view, points_m, std::vector{Eigen::Vector4f(1, 0, 0, 1)}, 4.0F, out);
    for (const ClipVertex& v : out) EXPECT_GE(v.clip.w(), static_cast<float>(view.near_m));
    return out.size();
  };
  EXPECT_EQ(vertices({{-1, 0.2F, 0}, {3, 0.2F, 0}}), 6U);
  EXPECT_EQ(vertices({{3, 0.2F, 0}, {-1, 0.2F, 0}, {3, -0.2F, 0}}), 12U);
  EXPECT_EQ(vertices({{-3, 0, 0}, {-1, 1, 0}}), 0U);
}

}  // namespace
}  // namespace swiftlet::sim
