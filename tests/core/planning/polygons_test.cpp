// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/polygons.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/map/overlaid_occupancy.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

using Eigen::Vector2d;

Polygon rectangle(double x0, double y0, double x1, double y1) { return {{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}, {}}; }
Polygon with_hole(Polygon polygon, const Polygon& hole) {
  Outline outline = hole.border;
  std::reverse(outline.begin(), outline.end());
  polygon.holes.push_back(outline);
  return polygon;
}

TEST(Region, OfRectanglesIsWhatOneComputesByHand) {
  const Region a = {rectangle(0, 0, 4, 3)}, b = {rectangle(1, 1, 6, 2)};
  EXPECT_NEAR(area_m2(intersection_of(a, b)), 3.0, 1e-9);
  EXPECT_NEAR(area_m2(difference_of(a, b)), 9.0, 1e-9);
  EXPECT_NEAR(area_m2(union_of(std::vector{a, b})), 14.0, 1e-9);
  const Region ring = difference_of(a, {rectangle(1, 1, 2, 2)});
  ASSERT_EQ(ring.size(), 1U);
  ASSERT_EQ(ring[0].holes.size(), 1U);
  EXPECT_FALSE(contains(ring, {1.5, 1.5}));
  EXPECT_TRUE(contains(ring, {0.5, 1.5}));
  EXPECT_TRUE(intersection_of(ring, {rectangle(1.1, 1.1, 1.9, 1.9)}).empty()) << "all of it in the hole";
  const Region pieces = difference_of(a, {rectangle(1, -1, 2, 4)});
  EXPECT_EQ(pieces.size(), 2U);
  // An island in the hole of a ring is a piece of its own.
  const Region island = union_of(std::vector<Region>{ring, {rectangle(1.4, 1.4, 1.6, 1.6)}});
  EXPECT_EQ(island.size(), 2U);
  EXPECT_NEAR(area_m2(island), 11.04, 1e-9);
}

// Polygons at random against points at random: a point is in the result when it is in the operands.
TEST(Region, HoldsExactlyTheRightPointsOfRandomStars) {
  const Random random(6, "stars");
  for (std::uint32_t k = 0; k < 20; ++k) {
    const auto star = [&](std::uint32_t channel, const Vector2d& middle) {
      Polygon polygon;
      for (std::uint32_t i = 0; i < 24; ++i) {
        const double angle = 2.0 * M_PI * i / 24, radius = random.uniform(0.5, 3.0, k, 100 * channel + i);
        polygon.border.push_back(middle + radius * Vector2d(std::cos(angle), std::sin(angle)));
      }
      return Region{polygon};
    };
    const Region a = star(0, {0, 0}), b = star(1, {1, 0.5});
    const Region both = intersection_of(a, b), either = union_of(std::vector{a, b}), only_a = difference_of(a, b);
    EXPECT_NEAR(area_m2(both) + area_m2(either), area_m2(a) + area_m2(b), 1e-4);
    for (std::uint32_t i = 0; i < 300; ++i) {
      const Vector2d p(random.uniform(-3, 4, k, 1000 + 2 * i), random.uniform(-3, 4, k, 1001 + 2 * i));
      if (std::abs(depth_m(a[0], p)) < 1e-4 || std::abs(depth_m(b[0], p)) < 1e-4) continue;
      const bool in_a = contains(a, p), in_b = contains(b, p);
      EXPECT_EQ(contains(both, p), in_a && in_b);
      EXPECT_EQ(contains(either, p), in_a || in_b);
      EXPECT_EQ(contains(only_a, p), in_a && !in_b);
    }
  }
}

// The edges that Boost.Geometry 1.74 takes wrongly: nearly along each other.
TEST(Region, OfNearlyCollinearEdgesIsSound) {
  for (int i = 1; i < 40; ++i) {
    const double tilt = 1e-6 * i;
    const Region a = {rectangle(0, 0, 10, 1)}, b = {{{{0, 1 - tilt}, {10, 1 + tilt}, {10, 2}, {0, 2}}, {}}};
    const double sum = area_m2(a) + area_m2(b);
    EXPECT_NEAR(area_m2(intersection_of(a, b)) + area_m2(union_of(std::vector{a, b})), sum, 1e-4) << i;
  }
}

TEST(Buffer, IsAllThatIsNearThePath) {
  const std::vector<Vector2d> path = {{0, 0}, {4, 0}, {4, 3}};
  const Region buffer = buffer_of(path, 2.0);
  const Random random(2, "points");
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const Vector2d p(random.uniform(-3, 8, 0, i), random.uniform(-3, 6, 1, i));
    const double to_first = std::hypot(p.x() - std::clamp(p.x(), 0.0, 4.0), p.y());
    const double to_second = std::hypot(p.x() - 4.0, p.y() - std::clamp(p.y(), 0.0, 3.0));
    const double distance = std::min(to_first, to_second);
    if (distance > 2.0 - 1e-5 && distance < 2.005) continue;  // between the circle and its corners
    EXPECT_EQ(contains(buffer, p), distance < 2.0) << p.transpose();
  }
  EXPECT_NEAR(area_m2(buffer_of(std::vector<Vector2d>{{1, 1}}, 1.0)), M_PI, 0.01) << "a single place";
}

TEST(RegionOfCells, HasTheAreaAndThePiecesOfTheCells) {
  // A ring with an island in it, and two cells that touch at a corner.
  const std::vector<std::string> rows = {"#####..#", "#...#.#.", "#.#.#...", "#...#...", "#####..."};
  std::vector<bool> cells;
  int count = 0;
  for (const std::string& row : rows) {
    for (const char c : row) cells.push_back(c == '#'), count += c == '#';
  }
  const Region region = region_of_cells({1.0, 2.0}, 0.5, 8, 5, cells);
  EXPECT_NEAR(area_m2(region), 0.25 * count, 1e-12);
  EXPECT_EQ(region.size(), 4U) << "ring, island, and two cells that only touch";
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 8; ++x) {
      EXPECT_EQ(contains(region, {1.25 + 0.5 * x, 2.25 + 0.5 * y}),
                rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] == '#');
    }
  }
  const Random random(9, "cells");
  for (std::uint32_t k = 0; k < 20; ++k) {
    std::vector<bool> any;
    for (std::uint32_t i = 0; i < 20 * 15; ++i) any.push_back(random.uniform(k, i) < 0.55);
    const Region made = region_of_cells({0, 0}, 1.0, 20, 15, any);
    EXPECT_NEAR(area_m2(made), static_cast<double>(std::count(any.begin(), any.end(), true)), 1e-9);
    for (int i = 0; i < 300; ++i)
      EXPECT_EQ(contains(made, {i % 20 + 0.5, i / 20 + 0.5}), any[static_cast<std::size_t>(i)]);
  }
}

TEST(VisibleFrom, SeesARoomButNotWhatAPillarHides) {
  // Nothing but a pillar of 1 m x 1 m, whose front is 2 m away.
  OccupancyMapConfig config;
  const OccupancyMap nothing(config);
  const OverlaidOccupancy view(nothing, {KeepOut::box({2.5, 0, 1}, {1, 1, 2})});
  const Region seen = visible_from(view, {0, 0, 1}, 6.0, 3600);
  EXPECT_TRUE(contains(seen, {1.9, 0.0}));
  EXPECT_FALSE(contains(seen, {2.1, 0.0}));
  EXPECT_FALSE(contains(seen, {5.0, 0.0}));
  EXPECT_TRUE(contains(seen, {5.0, 3.0}));
  EXPECT_TRUE(contains(seen, {-5.9, 0.0}));
  // What is hidden: the sector behind the front's edges, less the triangle before it.
  const double half_angle = std::atan2(0.5, 2.0);
  EXPECT_NEAR(area_m2(seen), M_PI * 36.0 - half_angle * 36.0 + 0.5 * 2.0 * 1.0, 0.1);
  const Region above = visible_from(view, {0, 0, 3}, 6.0, 500);
  EXPECT_NEAR(area_m2(above), M_PI * 36.0, 0.02);
}

TEST(Pole, LiesWhereTheLargestCircleFits) {
  const Pole square = pole_of_inaccessibility(rectangle(0, 0, 4, 4), 0.01);
  EXPECT_NEAR(square.depth_m, 2.0, 0.01);
  EXPECT_LT((square.p_m - Vector2d(2, 2)).norm(), 0.05);
  EXPECT_NEAR(pole_of_inaccessibility(rectangle(0, 0, 9, 2), 0.01).depth_m, 1.0, 0.01);
  // An L of two arms 2 m wide: the circle in its corner touches both outer walls and the inner corner.
  const Polygon l = {{{0, 0}, {6, 0}, {6, 2}, {2, 2}, {2, 6}, {0, 6}}, {}};
  EXPECT_NEAR(pole_of_inaccessibility(l, 0.001).depth_m, 2.0 * std::sqrt(2.0) / (1.0 + std::sqrt(2.0)), 0.002);
  // Around a square hole, the corner of a room: r from both walls, and from the corner of the hole at (3, 3).
  const Pole ring = pole_of_inaccessibility(with_hole(rectangle(0, 0, 8, 8), rectangle(3, 3, 5, 5)), 0.001);
  EXPECT_NEAR(ring.depth_m, 3.0 * std::sqrt(2.0) / (1.0 + std::sqrt(2.0)), 0.002);
}

// Against a fine grid of points.
TEST(Pole, IsAsDeepAsAnyPointOfRandomPolygons) {
  const Random random(12, "poles");
  for (std::uint32_t k = 0; k < 10; ++k) {
    Polygon polygon;
    for (std::uint32_t i = 0; i < 15; ++i) {
      const double angle = 2.0 * M_PI * i / 15, radius = random.uniform(0.5, 3.0, k, i);
      polygon.border.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
    double most = 0.0;
    for (int x = -60; x <= 60; ++x) {
      for (int y = -60; y <= 60; ++y) most = std::max(most, depth_m(polygon, {0.05 * x, 0.05 * y}));
    }
    const Pole pole = pole_of_inaccessibility(polygon, 0.01);
    EXPECT_GE(pole.depth_m, most - 0.01) << k;
    EXPECT_NEAR(pole.depth_m, depth_m(polygon, pole.p_m), 1e-12);
  }
}

}  // namespace
}  // namespace swiftlet
