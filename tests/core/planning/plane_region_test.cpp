// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/plane_region.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

PlaneRegion rectangle(double x0, double y0, double x1, double y1) {
  return inside_of({{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}});
}

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

PlaneRegion random_star(std::uint32_t trial, std::uint32_t which) {
  const Random random(trial, "test.star");
  Ring ring;
  for (std::uint32_t k = 0; k < 17; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / 17, r = random.uniform(0.4, 2.5, which, k);
    ring.emplace_back(r * std::cos(angle) + 0.7 * which, r * std::sin(angle) - 0.3 * which);
  }
  return inside_of(ring);
}

TEST(PlaneRegion, SetOperationsMatchPointMembership) {
  for (std::uint32_t trial = 0; trial < 12; ++trial) {
    const PlaneRegion a = random_star(trial, 0), b = random_star(trial, 1);
    const PlaneRegion both[] = {a, b};
    const PlaneRegion any = union_of(both), common = intersection_of(a, b), rest = difference_of(a, b);
    double cells = 0.0;
    for (int i = -60; i < 80; ++i) {
      for (int j = -70; j < 70; ++j) {
        const Vector2 p_m(0.05 * i + 0.013, 0.05 * j + 0.017);
        const bool in_a = contains(a, p_m), in_b = contains(b, p_m);
        ASSERT_EQ(contains(any, p_m), in_a || in_b);
        ASSERT_EQ(contains(common, p_m), in_a && in_b);
        ASSERT_EQ(contains(rest, p_m), in_a && !in_b);
        cells += in_a ? 0.0025 : 0.0;
      }
    }
    EXPECT_NEAR(area_m2(a), cells, 0.1);
    EXPECT_NEAR(area_m2(any), area_m2(a) + area_m2(b) - area_m2(common), 1e-5);
    EXPECT_NEAR(area_m2(rest), area_m2(a) - area_m2(common), 1e-5);
  }
}

TEST(PlaneRegion, BorderDistanceMatchesDenseSampling) {
  const Random random(2, "test.border");
  for (std::uint32_t trial = 0; trial < 6; ++trial) {
    const PlaneRegion region = random_star(trial, 0);
    std::vector<Vector2> border_m;
    for (const Ring& ring : region.rings_m) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vector2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
        for (int k = 0; k < 1000; ++k) border_m.push_back(a + (b - a) * (k / 1000.0));
      }
    }
    for (std::uint32_t k = 0; k < 60; ++k) {
      const Vector2 p_m(random.uniform(-4, 4, trial, 2 * k), random.uniform(-4, 4, trial, 2 * k + 1));
      double least_m = 1e9;
      for (const Vector2& q_m : border_m) least_m = std::min(least_m, (q_m - p_m).norm());
      EXPECT_NEAR(distance_to_border_m(region, p_m), least_m, 2e-3);
    }
    const Pole pole = pole_of_inaccessibility(region, 0.003);
    EXPECT_TRUE(contains(region, pole.p_m));
    EXPECT_NEAR(distance_to_border_m(region, pole.p_m), pole.distance_m, 1e-9);
  }
  // A single point has edges of zero length.
  PlaneRegion point;
  point.rings_m = {{{1, 2}, {1, 2}, {1, 2}}};
  EXPECT_NEAR(distance_to_border_m(point, {4, 6}), 5.0, 1e-12);
}

TEST(PlaneRegion, PathBufferIsWithinHalfPercent) {
  const Random random(3, "test.around");
  for (std::uint32_t trial = 0; trial < 8; ++trial) {
    std::vector<Vector2> path;
    for (std::uint32_t i = 0; i <= trial % 4; ++i)
      path.emplace_back(random.uniform(-3, 3, trial, 2 * i), random.uniform(-3, 3, trial, 2 * i + 1));
    const PlaneRegion around = around_path(path, 0.8);
    for (std::uint32_t k = 0; k < 1500; ++k) {
      const Vector2 p_m(random.uniform(-4, 4, trial, 100 + 2 * k), random.uniform(-4, 4, trial, 101 + 2 * k));
      double least_m = (path[0] - p_m).norm();
      for (std::size_t i = 1; i < path.size(); ++i) {
        const Vector2 leg = path[i] - path[i - 1];
        const double share = std::clamp((p_m - path[i - 1]).dot(leg) / leg.squaredNorm(), 0.0, 1.0);
        least_m = std::min(least_m, (path[i - 1] + share * leg - p_m).norm());
      }
      if (least_m > 0.8 - 1e-5 && least_m < 0.8 * 1.005) continue;
      ASSERT_EQ(contains(around, p_m), least_m < 0.8) << trial << " " << least_m;
    }
  }
  EXPECT_TRUE(around_path({}, 1.0).empty());
  EXPECT_TRUE(inside_of({{0, 0}, {1, 0}}).empty()) << "a line goes around nothing";
  EXPECT_NEAR(area_m2(inside_of({{0, 0}, {1, 0}, {0, 1}})), 0.5, 1e-9);
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
  for (std::uint32_t trial = 0; trial < 20; ++trial) {
    const PlaneRegion region = difference_of(random_star(trial, 0), rectangle(-0.2, -0.2, 0.6, 0.3));
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

TEST(Pole, LiesInTheLShapesCorner) {
  // The largest disc touches both outer sides and the inner corner: r = 1 / (1 + 1 / sqrt 2) = 2 - sqrt 2.
  const PlaneRegion l_shape = inside_of({{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 4}, {0, 4}});
  const Pole pole = pole_of_inaccessibility(l_shape, 1e-4);
  EXPECT_NEAR(pole.distance_m, 2.0 - std::numbers::sqrt2, 1e-4);
  EXPECT_TRUE(contains(l_shape, pole.p_m));
}

TEST(Pole, AvoidsHoles) {
  const PlaneRegion ring = difference_of(rectangle(0, 0, 6, 6), rectangle(2, 2, 5, 5));
  const Pole pole = pole_of_inaccessibility(ring, 1e-3);
  // In the corner between two strips of 2 m the disc touches both sides and the hole's corner.
  EXPECT_NEAR(pole.distance_m, 2.0 * (2.0 - std::numbers::sqrt2), 2e-3);
}

TEST(Pole, MatchesExhaustiveSearch) {
  for (std::uint32_t trial = 0; trial < 10; ++trial) {
    const PlaneRegion region = random_star(trial, 0);
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
