// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/sampled_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/math/random.hpp"
#include "tests/core/planning/box_map.hpp"

namespace swiftlet {
namespace {

using testing::BoxMap;

constexpr double kClearance_m = 0.25;

ClearPathConfig sampled_rules() {
  ClearPathConfig config;
  config.clearance_m = kClearance_m;
  return config;
}

SamplingConfig few_meters() {
  SamplingConfig config;
  config.step_m = 0.6;
  config.margin_m = 1.0;
  return config;
}

/// Farther than the clearance from every occupied cell, center to center, looked at every 5 mm.
void expect_clear(const BoxMap& map, const std::vector<Vector3>& corners_m) {
  std::vector<Vector3> occupied_m;
  map.occupied_in(Vector3::Zero(), map.grid().size.cast<double>() * map.edge_m(), occupied_m);
  for (std::size_t i = 1; i < corners_m.size(); ++i) {
    const Vector3 &a = corners_m[i - 1], &b = corners_m[i];
    const int steps = 1 + static_cast<int>((b - a).norm() / 0.005);
    for (int s = 0; s <= steps; ++s) {
      const Vector3 p_m = a + (b - a) * (static_cast<double>(s) / steps);
      const Cell cell = (p_m.array() / map.edge_m()).floor().cast<int>();
      // Where the segment only touches a corner of a cell, the neighboring cell may have been tested instead.
      const Eigen::Array3d inside = p_m.array() / map.edge_m() - cell.cast<double>().array();
      if (inside.minCoeff() < 0.25 || inside.maxCoeff() > 0.75) continue;
      for (const Vector3& occupied : occupied_m) {
        ASSERT_GT((map.grid().center_m(cell) - occupied).norm(), kClearance_m) << p_m.transpose();
      }
    }
  }
}

/// A room of 6 m x 4 m x 2 m with a wall across at x = 3 m, open above y = 3 m.
BoxMap wall_with_a_gap() {
  BoxMap map({60, 40, 20}, 0.1);
  for (int y = 0; y < 30; ++y) {
    for (int z = 0; z < 20; ++z) map.at({30, y, z}) = CellState::kOccupied;
  }
  return map;
}
const Vector3 kStart(1.05, 1.05, 1.05), kGoal(5.05, 1.05, 1.05);

ClearPath through_the_gap(SampledSearch search, std::uint32_t draw, int max_samples = 2000, int max_shortenings = 0) {
  ClearPathConfig config = sampled_rules();
  config.max_shortenings = max_shortenings;
  SamplingConfig sampling = few_meters();
  sampling.max_samples = max_samples;
  sampling.margin_m = 4.0;
  return find_sampled_path(wall_with_a_gap(), config, sampling, search, kStart, kGoal, draw);
}

TEST(SampledPath, FindsExistingClearPaths) {
  int there = 0, found = 0, none = 0;
  for (std::uint32_t k = 0; k < 40; ++k) {
    const Random random(k, "boxes");
    BoxMap map({30, 24, 12}, 0.1);
    for (std::uint32_t i = 0; i < (k % 4 == 0 ? 400 : 60); ++i) {
      const auto draw = [&](int axis, int size) {
        return static_cast<int>(size * random.uniform(i, static_cast<std::uint32_t>(axis)));
      };
      const Cell low(6 + draw(0, 18), draw(1, 22), draw(2, 10));
      for (int c = 0; c < 8; ++c) map.at(low + Cell(c & 1, c >> 1 & 1, c >> 2)) = CellState::kOccupied;
    }
    const Vector3 start_m(0.15, 0.15, 0.55), goal_m(2.85, 2.25, 0.55);
    const ClearPath cells = find_clear_path(map, sampled_rules(), start_m, goal_m);
    for (const SampledSearch search : {SampledSearch::kRrt, SampledSearch::kInformedRrtStar}) {
      const ClearPath path = find_sampled_path(map, sampled_rules(), few_meters(), search, start_m, goal_m);
      if (cells.status != ClearPathStatus::kFound) {
        ++none;
        EXPECT_NE(path.status, ClearPathStatus::kFound) << k;
        continue;
      }
      if (k % 4 != 0) ++there;
      if (path.status != ClearPathStatus::kFound) continue;
      if (k % 4 != 0) ++found;
      EXPECT_EQ(path.corners_local_m.front(), start_m);
      EXPECT_EQ(path.corners_local_m.back(), goal_m);
      expect_clear(map, path.corners_local_m);
    }
  }
  EXPECT_GT(there, 20);
  EXPECT_GT(none, 4);
  EXPECT_GE(found, 0.9 * there);
}

TEST(SampledPath, OnlyInformedRrtStarNearsOptimum) {
  // Around the edge of the wall, at the clearance from it: two straight legs.
  const Vector3 edge_m(3.05, 2.95, 1.05);
  const double shortest_m =
      2.0 * std::sqrt(2.0 * 2.0 + (edge_m.y() + kClearance_m - 1.05) * (edge_m.y() + kClearance_m - 1.05));
  double star_m = 0.0, first_m = 0.0;
  constexpr int kDraws = 10;
  for (std::uint32_t draw = 0; draw < kDraws; ++draw) {
    const ClearPath star = through_the_gap(SampledSearch::kInformedRrtStar, draw);
    const ClearPath first = through_the_gap(SampledSearch::kRrt, draw);
    ASSERT_EQ(star.status, ClearPathStatus::kFound);
    ASSERT_EQ(first.status, ClearPathStatus::kFound);
    expect_clear(wall_with_a_gap(), star.corners_local_m);
    expect_clear(wall_with_a_gap(), first.corners_local_m);
    EXPECT_LT(length_m(star.corners_local_m), 1.2 * shortest_m) << draw;
    EXPECT_EQ(star.expansions, 2000U);
    EXPECT_LT(first.expansions, 2000U);
    star_m += length_m(star.corners_local_m) / kDraws;
    first_m += length_m(first.corners_local_m) / kDraws;
  }
  EXPECT_LT(star_m, 1.12 * shortest_m);
  EXPECT_GT(first_m, 1.15 * star_m);
}

TEST(SampledPath, MoreSamplesNeverMakeItLonger) {
  for (std::uint32_t draw = 0; draw < 4; ++draw) {
    double last_m = 1e9;
    for (int samples = 250; samples <= 4000; samples *= 2) {
      const ClearPath path = through_the_gap(SampledSearch::kInformedRrtStar, draw, samples);
      if (path.status != ClearPathStatus::kFound) continue;
      EXPECT_LE(length_m(path.corners_local_m), last_m) << draw << ": " << samples;
      last_m = length_m(path.corners_local_m);
    }
    EXPECT_LT(last_m, 1e9);
  }
}

TEST(SampledPath, CutsCornersOfFoundPath) {
  EXPECT_LT(length_m(through_the_gap(SampledSearch::kRrt, 1, 2000, 5).corners_local_m),
            length_m(through_the_gap(SampledSearch::kRrt, 1, 2000, 0).corners_local_m));
}

TEST(SampledPath, DependsOnItsDrawAlone) {
  const auto path = [](std::uint32_t draw) { return through_the_gap(SampledSearch::kRrt, draw).corners_local_m; };
  EXPECT_EQ(path(3), path(3));
  EXPECT_NE(path(3), path(4));
}

TEST(SampledPath, StaysWithinTheHeights) {
  ClearPathConfig config = sampled_rules();
  config.max_shortenings = 0;
  config.z_min_m = 0.9;
  config.z_max_m = 1.2;
  const ClearPath path =
      find_sampled_path(wall_with_a_gap(), config, few_meters(), SampledSearch::kInformedRrtStar, kStart, kGoal);
  SamplingConfig wide = few_meters();
  wide.margin_m = 4.0;
  const ClearPath around =
      find_sampled_path(wall_with_a_gap(), config, wide, SampledSearch::kInformedRrtStar, kStart, kGoal);
  EXPECT_EQ(path.status, ClearPathStatus::kBudgetSpent) << "the gap is 2 m from both, the samples are not";
  ASSERT_EQ(around.status, ClearPathStatus::kFound);
  for (const Vector3& corner : around.corners_local_m) {
    EXPECT_GE(corner.z(), 0.9);
    EXPECT_LE(corner.z(), 1.2);
  }
}

TEST(SampledPath, ExplainsImpossiblePathsWithoutSampling) {
  BoxMap map = wall_with_a_gap();
  const auto status = [&](const Vector3& goal_m) {
    const ClearPath path = find_sampled_path(map, sampled_rules(), few_meters(), SampledSearch::kRrt, kStart, goal_m);
    EXPECT_EQ(path.expansions, 0U);
    return path.status;
  };
  EXPECT_EQ(status({3.05, 1.05, 1.05}), ClearPathStatus::kGoalBlocked);
  EXPECT_EQ(status({1e9, 0, 0}), ClearPathStatus::kGoalTooFar);
  map.at({50, 10, 10}) = CellState::kUnknown;
  EXPECT_EQ(status(kGoal), ClearPathStatus::kGoalUnknown);
}

TEST(PointInSpheroid, HasGivenPathLengthBetweenFoci) {
  const Random random(5, "spheroid");
  const auto draw = [&](std::uint32_t k, std::uint32_t i) { return random.uniform(-1.0, 1.0, k, i); };
  for (std::uint32_t k = 0; k < 200; ++k) {
    const Vector3 a(draw(k, 0), draw(k, 1), draw(k, 2)), b(draw(k, 3), draw(k, 4), draw(k, 5));
    const double length_m = (b - a).norm() + 1.0 + draw(k, 6);
    const Vector3 on_sphere = Vector3(draw(k, 7), draw(k, 8), draw(k, 9)).normalized();
    const Vector3 rim_m = point_in_spheroid(a, b, length_m, on_sphere);
    EXPECT_NEAR((rim_m - a).norm() + (rim_m - b).norm(), length_m, 1e-12);
    const Vector3 inside_m = point_in_spheroid(a, b, length_m, 0.7 * on_sphere);
    EXPECT_LT((inside_m - a).norm() + (inside_m - b).norm(), length_m);
    EXPECT_LT((point_in_spheroid(a, b, length_m, Vector3::Zero()) - 0.5 * (a + b)).norm(), 1e-12);
  }
  const Vector3 p_m(1, 2, 3);
  EXPECT_LT((point_in_spheroid(p_m, p_m, 2.0, Vector3::UnitZ()) - p_m).norm(), 1.0 + 1e-12) << "one focus: a ball";
}

}  // namespace
}  // namespace swiftlet
