// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/plane_region.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

PlaneRegion rectangle(double x0, double y0, double x1, double y1) {
  return inside_of({{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}});
}

PlaneRegion l_shape() { return inside_of({{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 4}, {0, 4}}); }

TEST(PlaneRegion, MatchesTheExactAreaOfRectangles) {
  const PlaneRegion a = rectangle(0, 0, 4, 3), b = rectangle(2, 1, 6, 5);
  EXPECT_NEAR(area_m2(a), 12.0, 1e-9);
  EXPECT_NEAR(area_m2(intersection_of(a, b)), 4.0, 1e-9);
  EXPECT_NEAR(area_m2(difference_of(a, b)), 8.0, 1e-9);
  EXPECT_NEAR(area_m2(union_of(std::vector{a, b})), 24.0, 1e-9);
}

TEST(PlaneRegion, IgnoresLineDirection) {
  EXPECT_NEAR(area_m2(inside_of({{0, 0}, {0, 2}, {2, 2}, {2, 0}})), 4.0, 1e-9);
}

TEST(PlaneRegion, HasNoIntersectionWhenMerelyTouching) {
  EXPECT_TRUE(intersection_of(rectangle(0, 0, 1, 1), rectangle(1, 0, 2, 1)).empty());
  EXPECT_TRUE(intersection_of(rectangle(0, 0, 1, 1), rectangle(5, 5, 6, 6)).empty());
}

TEST(PlaneRegion, HandlesNearlyCollinearEdges) {
  // Rays of a visibility region along a wall end a nanometer before or behind each other.
  Ring jagged{{0, 0}};
  for (int i = 0; i <= 400; ++i) jagged.emplace_back(0.01 * i, 1.0 + (i % 3 - 1) * 1e-9);
  jagged.emplace_back(4, 0);
  const PlaneRegion region = inside_of(jagged);
  EXPECT_NEAR(area_m2(region), 4.0, 1e-5);
  const PlaneRegion cut = intersection_of(region, rectangle(1, 0.999999, 3, 2));
  EXPECT_LT(area_m2(cut), 1e-5);
  EXPECT_NEAR(area_m2(difference_of(region, rectangle(1, -1, 3, 1.0000005))), 2.0, 1e-5);
}

TEST(PlaneRegion, SurroundsAPathByItsDistance) {
  const std::vector<Vector2> path = {{0, 0}, {3, 0}, {3, 4}};
  const double r = 0.5;
  const PlaneRegion around = around_path(path, r);
  // Two rectangles, half a disc at each end, and the outer quarter of a disc in the corner, where r^2 is counted twice.
  const double exact = 2 * r * 7.0 - r * r + 1.25 * std::numbers::pi * r * r;
  EXPECT_GT(area_m2(around), exact);
  EXPECT_LT(area_m2(around), exact * 1.005);
  for (int k = 0; k < 720; ++k) {
    const double angle = k * std::numbers::pi / 360.0;
    const Vector2 direction(std::cos(angle), std::sin(angle));
    EXPECT_TRUE(contains(around, path.front() + 0.9999 * r * direction));
    EXPECT_TRUE(contains(around, path.back() + 0.9999 * r * direction));
  }
  EXPECT_FALSE(contains(around, {3.51, 2.0}));
  EXPECT_NEAR(area_m2(around_path(std::vector<Vector2>{{1, 1}}, 2.0)), 4 * std::numbers::pi,
              0.005 * 4 * std::numbers::pi);
}

TEST(PlaneRegion, PartsKeepTheirHoles) {
  const PlaneRegion with_hole = difference_of(rectangle(0, 0, 3, 3), rectangle(1, 1, 2, 2));
  const PlaneRegion island = rectangle(1.25, 1.25, 1.75, 1.75);
  const std::vector<PlaneRegion> parts = parts_of(union_of(std::vector{with_hole, island, rectangle(5, 0, 6, 1)}));
  ASSERT_EQ(parts.size(), 3U);
  std::vector<double> areas;
  for (const PlaneRegion& part : parts) areas.push_back(area_m2(part));
  std::sort(areas.begin(), areas.end());
  EXPECT_NEAR(areas[0], 0.25, 1e-9);
  EXPECT_NEAR(areas[1], 1.0, 1e-9);
  EXPECT_NEAR(areas[2], 8.0, 1e-9);
  EXPECT_FALSE(contains(with_hole, {1.5, 1.5}));
  EXPECT_TRUE(contains(with_hole, {0.5, 1.5}));
}

TEST(PlaneRegion, CellsAreJoinedAcrossEdgesOnly) {
  CellMask mask{.origin_m = {-1, 2}, .edge_m = 0.5, .columns = 4, .rows = 3, .cells = std::vector<char>(12)};
  for (const auto& [column, row] : {std::pair(0, 0), {1, 0}, {1, 1}, {2, 2}, {3, 2}}) mask.at(column, row) = 1;
  const PlaneRegion region = region_of(mask);
  EXPECT_NEAR(area_m2(region), 5 * 0.25, 1e-9);
  EXPECT_EQ(parts_of(region).size(), 2U) << "cells (1, 1) and (2, 2) share a corner only";
}

TEST(PlaneRegion, MarksCellsWithCentersInside) {
  const Random random(7, "test", "plane_region");
  for (int trial = 0; trial < 20; ++trial) {
    Ring star;
    for (int k = 0; k < 40; ++k) {
      const double angle = 2 * std::numbers::pi * k / 40, r = 0.3 + 2.0 * random.uniform(trial, k);
      star.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
    const PlaneRegion region = difference_of(inside_of(star), rectangle(-0.2, -0.2, 0.6, 0.3));
    CellMask mask{
        .origin_m = {-2.03, -1.97}, .edge_m = 0.1, .columns = 38, .rows = 41, .cells = std::vector<char>(38 * 41)};
    mark_inside(region, mask);
    for (int row = 0; row < mask.rows; ++row) {
      for (int column = 0; column < mask.columns; ++column) {
        EXPECT_EQ(mask.at(column, row) != 0, contains(region, mask.center_m(column, row))) << column << ", " << row;
      }
    }
  }
}

TEST(PlaneRegion, RestoresTheCellsOfAMask) {
  CellMask mask{.origin_m = {0.3, -0.7}, .edge_m = 0.1, .columns = 30, .rows = 20, .cells = std::vector<char>(600)};
  const Random random(8, "test", "plane_region");
  for (std::size_t i = 0; i < mask.cells.size(); ++i) mask.cells[i] = random.uniform(0, i) < 0.6;
  CellMask back = mask;
  std::fill(back.cells.begin(), back.cells.end(), char{0});
  mark_inside(region_of(mask), back);
  EXPECT_EQ(back.cells, mask.cells);
}

TEST(Pole, IsCentralInSquaresAndDiscs) {
  const Pole square = pole_of_inaccessibility(rectangle(1, 2, 5, 6), 1e-3);
  EXPECT_NEAR(square.distance_m, 2.0, 1e-3);
  EXPECT_LT((square.p_m - Vector2(3, 4)).norm(), 2e-3);
  const Pole disc = pole_of_inaccessibility(around_path(std::vector<Vector2>{{-3, 1}}, 1.5), 1e-3);
  EXPECT_NEAR(disc.distance_m, 1.5, 1e-3);
}

TEST(Pole, LiesInTheLShapesCorner) {
  // The largest disc touches both outer sides and the inner corner: r = 1 / (1 + 1 / sqrt 2) = 2 - sqrt 2.
  const Pole pole = pole_of_inaccessibility(l_shape(), 1e-4);
  EXPECT_NEAR(pole.distance_m, 2.0 - std::numbers::sqrt2, 1e-4);
  EXPECT_TRUE(contains(l_shape(), pole.p_m));
}

TEST(Pole, AvoidsHoles) {
  const PlaneRegion ring = difference_of(rectangle(0, 0, 6, 6), rectangle(2, 2, 5, 5));
  const Pole pole = pole_of_inaccessibility(ring, 1e-3);
  // In the corner between two strips of 2 m the disc touches both sides and the hole's corner.
  EXPECT_NEAR(pole.distance_m, 2.0 * (2.0 - std::numbers::sqrt2), 2e-3);
}

TEST(Pole, MatchesExhaustiveSearch) {
  const Random random(9, "test", "plane_region");
  for (int trial = 0; trial < 10; ++trial) {
    Ring star;
    for (int k = 0; k < 24; ++k) {
      const double angle = 2 * std::numbers::pi * k / 24, r = 0.5 + 2.5 * random.uniform(trial, k);
      star.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
    const PlaneRegion region = inside_of(star);
    double best_m = 0.0;
    for (int i = -150; i <= 150; ++i) {
      for (int j = -150; j <= 150; ++j) {
        const Vector2 p_m(0.02 * i, 0.02 * j);
        if (contains(region, p_m)) best_m = std::max(best_m, distance_to_border_m(region, p_m));
      }
    }
    EXPECT_GE(pole_of_inaccessibility(region, 0.01).distance_m, best_m - 0.01) << trial;
  }
}

}  // namespace
}  // namespace swiftlet
