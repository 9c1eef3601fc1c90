// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/closure.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {
namespace {

using Points = std::vector<Eigen::Vector3f>;

/// Points of an upright rectangle, 0.15 m apart and 1 cm off.
void add_wall(Points& points, double x0, double y0, double x1, double y1, double height_m, std::mt19937& random) {
  std::normal_distribution<float> off(0.0F, 0.01F);
  const int n = static_cast<int>(std::hypot(x1 - x0, y1 - y0) / 0.15), m = static_cast<int>(height_m / 0.15);
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= m; ++j) {
      const float f = static_cast<float>(i) / static_cast<float>(n), z = 0.15F * static_cast<float>(j);
      const float dx = off(random), dy = off(random);
      points.emplace_back(static_cast<float>(x0 + f * (x1 - x0)) + dx, static_cast<float>(y0 + f * (y1 - y0)) + dy, z);
    }
  }
}

void add_floor(Points& points, double half_m, std::mt19937& random) {
  std::normal_distribution<float> off(0.0F, 0.01F);
  const int n = static_cast<int>(half_m / 0.25);
  for (int i = -n; i <= n; ++i) {
    for (int j = -n; j <= n; ++j) {
      points.emplace_back(0.25F * static_cast<float>(i), 0.25F * static_cast<float>(j), off(random));
    }
  }
}

/// A yard with irregular walls.
Points yard(unsigned seed) {
  std::mt19937 random(seed);
  Points points;
  add_floor(points, 12.0, random);
  add_wall(points, -10, -8, 9, -8, 4.0, random);
  add_wall(points, 9, -8, 9, 5, 3.0, random);
  add_wall(points, -10, -8, -10, 3, 5.0, random);
  add_wall(points, -4, 4, 1, 6, 3.0, random);
  add_wall(points, 3, 0, 5, 2.5, 2.5, random);
  return points;
}

/// Racks that look alike every 2.5 m.
Points aisles(unsigned seed) {
  std::mt19937 random(seed);
  Points points;
  add_floor(points, 12.0, random);
  for (int i = -4; i <= 4; ++i) add_wall(points, 2.5 * i, -9, 2.5 * i, 9, 4.0, random);
  for (int i = -4; i <= 4; ++i) add_wall(points, 2.5 * i, -9, 2.5 * i + 0.8, -9, 4.0, random);
  return points;
}

Points seen_from(const Points& points, const Pose& T_map_cloud) {
  Points out;
  out.reserve(points.size());
  const Pose T = T_map_cloud.inverse();
  for (const Eigen::Vector3f& p : points) out.push_back((T * p.cast<double>()).cast<float>());
  return out;
}

/// Closure of two submaps with a guess.
ClosureResult close_near(std::span<const Eigen::Vector3f> older_m, std::span<const Eigen::Vector3f> newer_m,
                         const Pose& T_guess, double guess_error_m, const ClosureConfig& config = {}) {
  const ClosureCandidate candidate{Pose::Identity(), older_m, nullptr, T_guess, guess_error_m};
  return find_closure({&candidate, 1}, newer_m, config);
}

TEST(OccupancyPyramid, EveryLevelIsMaximumOfCells) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-4.0F, 4.0F);
  Points points(60);
  for (Eigen::Vector3f& p : points) {
    for (int axis = 0; axis < 3; ++axis) p(axis) = uniform(random);
  }
  const OccupancyPyramid pyramid(points, 0.5, 4);
  for (int level = 1; level < 4; ++level) {
    for (int x = -18; x < 12; ++x) {
      for (int y = -18; y < 12; ++y) {
        for (int z = -18; z < 12; z += 3) {
          bool any = false;
          for (int i = 0; i < 1 << level; ++i) {
            for (int j = 0; j < 1 << level; ++j) {
              for (int k = 0; k < 1 << level; ++k) any = any || pyramid.at(0, x + i, y + j, z + k);
            }
          }
          ASSERT_EQ(pyramid.at(level, x, y, z), any) << level << ": " << x << " " << y << " " << z;
        }
      }
    }
  }
}

TEST(RotationalHistogram, MatchesOnlyAtTheRightHeading) {
  const Points points = yard(1);
  const RotationalHistogram map(points);
  const RotationalHistogram turned(seen_from(points, make_pose({0, 0, 0}, rotation_by({0, 0, 0.4}))));
  EXPECT_GT(turned.similarity(map, 0.4), 0.85);
  EXPECT_LT(turned.similarity(map, 0.0), 0.6);
}

TEST(Closure, RecoversRelativePoseToACentimeter) {
  const Points older = yard(1);
  for (const double yaw_rad : {0.3, -2.0}) {
    const Pose T = make_pose({1.5, -0.8, 0.3}, rotation_by({0, 0, yaw_rad}));
    const Points newer = seen_from(yard(2), T);
    const Pose guess = make_pose(T.translation() + Vector3(-1.6, 1.2, -0.4), rotation_by({0, 0, yaw_rad + 0.08}));
    const ClosureResult result = close_near(older, newer, guess, 3.0);
    ASSERT_EQ(result.verdict, ClosureVerdict::kClosed) << static_cast<int>(result.verdict) << " " << result.score;
    const Pose off = T.inverse() * result.T_older_newer;
    EXPECT_LT(off.translation().norm(), 0.01);
    EXPECT_LT(rotation_vector_rad(Eigen::Quaterniond(Matrix3(off.linear()))).norm(), 0.002);
    EXPECT_GT(result.near_share, 0.9);
  }
}

TEST(Closure, RefusesAislesThatLookAlike) {
  const Pose T = make_pose({0.2, 0.3, 0.1}, rotation_by({0, 0, 0.02}));
  const ClosureResult result = close_near(aisles(1), seen_from(aisles(2), T), Pose::Identity(), 3.0);
  EXPECT_EQ(result.verdict, ClosureVerdict::kAmbiguous);
}

/// An aisle between full racks, from x0 to x1: a rack every 3 m, and nothing at its ends.
Points bays(double x0, double x1, unsigned seed) {
  std::mt19937 random(seed);
  Points points;
  add_floor(points, 6.0, random);
  for (int bay = -10; bay < 10; ++bay) {
    for (const double y : {-1.8, 1.8}) {
      const double left = 3.0 * bay, right = left + 1.2, back = y > 0.0 ? y + 0.8 : y - 0.8;
      if (left < x0 || right > x1) continue;
      add_wall(points, left, y, right, y, 4.0, random);
      add_wall(points, left, y, left, back, 4.0, random);
      add_wall(points, right, y, right, back, 4.0, random);
    }
  }
  return points;
}

// The newer submap goes on where the older one ends: a bay off, more of it lies on racks. Within the error of the
// guess, the right bay is taken although it scores less.
TEST(Closure, TakesNextBayForARival) {
  const Points older = bays(-15.0, 10.0, 1), newer = bays(-9.0, 16.0, 2);
  const Pose guess = make_pose({0.2, 0.1, 0}, Eigen::Quaterniond::Identity());
  EXPECT_EQ(close_near(older, newer, guess, 1e9).verdict, ClosureVerdict::kAmbiguous);
  const ClosureResult result = close_near(older, newer, guess, 0.5);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed) << "score " << result.score;
  EXPECT_LT(result.T_older_newer.translation().norm(), 0.02);
}

/// The floor and one long wall along x.
Points floor_and_wall(unsigned seed) {
  std::mt19937 random(seed);
  Points points;
  add_floor(points, 12.0, random);
  add_wall(points, -12, 4, 12, 4, 4.0, random);
  return points;
}

// The position along the wall is unobservable. All else is as accurate as in a whole yard.
TEST(Closure, LeavesDirectionAlongWallUnconstrained) {
  const Pose T = make_pose({0.0, 0.2, -0.15}, rotation_by({0, 0, 0.01}));
  const ClosureResult result = close_near(floor_and_wall(1), seen_from(floor_and_wall(2), T), Pose::Identity(), 0.5);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed) << static_cast<int>(result.verdict);
  const Pose off = T.inverse() * result.T_older_newer;
  EXPECT_LT(off.translation().tail<2>().norm(), 0.01);
  EXPECT_LT(std::abs(result.T_older_newer.translation().x()), 0.05) << "the guess is kept";
  EXPECT_LT(rotation_vector_rad(Eigen::Quaterniond(Matrix3(off.linear()))).norm(), 0.002);
  EXPECT_LT((result.observed * Vector6::Unit(0)).norm(), 0.05);
  for (const int axis : {1, 2, 3, 4, 5}) {
    EXPECT_LT((result.observed * Vector6::Unit(axis) - Vector6::Unit(axis)).head<3>().norm(), 0.5) << axis;
    EXPECT_LT((result.observed * Vector6::Unit(axis) - Vector6::Unit(axis)).tail<3>().norm(), 0.02) << axis;
  }
  EXPECT_LT((result.observed * result.observed - result.observed).norm(), 1e-9) << "a projector";
}

/// Floor and wall, and fins of 0.5 m across the wall.
Points wall_with_fins(unsigned seed, std::span<const double> fins_x_m) {
  Points points = floor_and_wall(seed);
  std::mt19937 random(seed + 100);
  for (const double x_m : fins_x_m) add_wall(points, x_m, 3.5, x_m, 4.0, 4.0, random);
  return points;
}

// From the guess no fin is in reach.
TEST(Closure, SlidesOffsetGuessAlongWall) {
  const double fins_x_m[] = {-7.4, -4.1, -3.0, 1.2, 2.9, 6.6};
  const Pose T = make_pose({0.58, 0.1, -0.05}, rotation_by({0, 0, 0.005}));
  const ClosureResult result =
      close_near(wall_with_fins(1, fins_x_m), seen_from(wall_with_fins(2, fins_x_m), T), Pose::Identity(), 0.6);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed) << static_cast<int>(result.verdict);
  EXPECT_LT((T.inverse() * result.T_older_newer).translation().norm(), 0.01);
  EXPECT_TRUE(result.observed.isIdentity());
}

// A fin and ribs determine the position to a millimeter. But the ribs are regular, and one fin is small. So the cloud
// fits at the next ribs about as well, and the closure does not constrain the direction along the wall.
TEST(Closure, RegularRibsLeaveWallDirectionUnconstrained) {
  const auto ribbed = [](unsigned seed) {
    const double fin_x_m[] = {-7.4};
    Points points = wall_with_fins(seed, fin_x_m);
    std::mt19937 random(seed + 200);
    for (int i = -39; i <= 39; ++i) add_wall(points, 0.3 * i, 3.8, 0.3 * i, 4.0, 0.6, random);
    return points;
  };
  const Pose T = make_pose({0.3, 0.1, -0.05}, rotation_by({0, 0, 0.005}));
  const ClosureResult result = close_near(ribbed(1), seen_from(ribbed(2), T), Pose::Identity(), 0.6);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed) << static_cast<int>(result.verdict);
  EXPECT_LT((T.inverse() * result.T_older_newer).translation().norm(), 0.01);
  EXPECT_LT((result.observed * Vector6::Unit(0)).norm(), 0.05);
  for (const int axis : {1, 2}) EXPECT_GT((result.observed * Vector6::Unit(axis)).norm(), 0.9) << axis;
}

TEST(Closure, ClosesNothingBeyondGuessError) {
  const Pose T = make_pose({0.9, 0.2, 0.1}, rotation_by({0, 0, 0.02}));
  const Points older = yard(1), newer = seen_from(yard(2), T);
  EXPECT_EQ(close_near(older, newer, Pose::Identity(), 0.7).verdict, ClosureVerdict::kDiverged);
  EXPECT_NE(close_near(older, newer, Pose::Identity(), 0.4).verdict, ClosureVerdict::kClosed);
  const ClosureResult result = close_near(older, newer, Pose::Identity(), 1.0);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed);
  EXPECT_TRUE(result.observed.isIdentity());
  EXPECT_LT((T.inverse() * result.T_older_newer).translation().norm(), 0.01);
}

// One shelf higher the view is much the same. A search would choose the height where more of the points meet cells of
// its grid.
TEST(Closure, KeepsShelfOfNearlyRightGuess) {
  const auto shelves = [](double lowest_m, double highest_m, unsigned seed) {
    std::mt19937 random(seed);
    Points points;
    for (int shelf = 0; shelf < 8; ++shelf) {
      const double z_m = 0.69 * shelf;
      if (z_m < lowest_m || z_m > highest_m) continue;
      for (const double y_m : {-1.8, 1.8}) {
        const auto begin = static_cast<std::ptrdiff_t>(points.size());
        add_wall(points, -8, y_m, 8, y_m, 0.4, random);
        add_wall(points, -8, y_m, -8, y_m > 0 ? 2.6 : -2.6, 0.4, random);
        add_wall(points, 8, y_m, 8, y_m > 0 ? 2.6 : -2.6, 0.4, random);
        for (auto p = points.begin() + begin; p != points.end(); ++p) p->z() += static_cast<float>(z_m);
        for (int i = -32; i <= 32; ++i) {
          for (int j = 0; j <= 4; ++j) {
            points.emplace_back(0.25F * static_cast<float>(i),
                                (y_m > 0 ? 1.0F : -1.0F) * (1.8F + 0.2F * static_cast<float>(j)),
                                static_cast<float>(z_m));
          }
        }
      }
    }
    return points;
  };
  const Pose T = make_pose({0.05, -0.05, 0.1}, rotation_by({0, 0, 0.005}));
  const ClosureResult result =
      close_near(shelves(0.0, 4.2, 1), seen_from(shelves(0.6, 5.0, 2), T), Pose::Identity(), 0.4);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed) << static_cast<int>(result.verdict);
  EXPECT_LT((T.inverse() * result.T_older_newer).translation().norm(), 0.02);
}

TEST(Closure, RefusesAnotherPlace) {
  std::mt19937 random(5);
  Points other;
  add_floor(other, 12.0, random);
  add_wall(other, -9, 7, 6, 9, 4.0, random);
  add_wall(other, -3, -6, -1, 2, 3.0, random);
  add_wall(other, 5, -9, 8, -4, 3.0, random);
  EXPECT_NE(close_near(yard(1), other, Pose::Identity(), 3.0).verdict, ClosureVerdict::kClosed);
}

TEST(Closure, RefusesBareFloorAndSingleWall) {
  std::mt19937 random(6);
  Points floor;
  add_floor(floor, 12.0, random);
  EXPECT_EQ(close_near(floor, floor, Pose::Identity(), 3.0).verdict, ClosureVerdict::kTooFlat);
  EXPECT_NE(close_near(floor, floor, Pose::Identity(), 0.5).verdict, ClosureVerdict::kClosed);
  Points wall = floor;
  add_wall(wall, -12, 4, 12, 4, 4.0, random);
  const ClosureVerdict verdict = close_near(wall, wall, Pose::Identity(), 3.0).verdict;
  EXPECT_TRUE(verdict == ClosureVerdict::kAmbiguous || verdict == ClosureVerdict::kUnobserved)
      << static_cast<int>(verdict);
}

TEST(ClosureInMap, FindsSubmapHeadingAndPlaceUnguided) {
  const Points first = yard(1), second = seen_from(yard(2), make_pose({4, -3, 0.5}, rotation_by({0, 0, 0.7})));
  Points far(first.size(), Eigen::Vector3f::Zero());
  for (std::size_t i = 0; i < far.size(); ++i) far[i] = {first[i].y() * 0.6F, first[i].x() * 0.8F, first[i].z()};
  const std::vector<ClosureCandidate> parts = {
      {make_pose({100, 0, 0}, Eigen::Quaterniond::Identity()), far},
      {make_pose({4, -3, 0.5}, rotation_by({0, 0, 0.7})), second},
  };
  const Pose T_map_cloud = make_pose({1.5, -1.0, 0.9}, rotation_by({0, 0, -2.2}));
  const ClosureResult result = find_closure(parts, seen_from(yard(3), T_map_cloud), {});
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed);
  EXPECT_EQ(result.candidate, 1U);
  const Pose off = T_map_cloud.inverse() * parts[1].T_map_older * result.T_older_newer;
  EXPECT_LT(off.translation().norm(), 0.02);
  EXPECT_LT(rotation_vector_rad(Eigen::Quaterniond(Matrix3(off.linear()))).norm(), 0.003);
}

TEST(ClosureInMap, RefusesTwoSimilarPlaces) {
  const Points there = yard(1);
  const std::vector<ClosureCandidate> twice = {
      {Pose::Identity(), there},
      {make_pose({100, 0, 0}, Eigen::Quaterniond::Identity()), there},
  };
  EXPECT_EQ(find_closure(twice, yard(3), {}).verdict, ClosureVerdict::kAmbiguous);
  // A duplicate of the submap at its place is no rival.
  const std::vector<ClosureCandidate> same = {twice[0], twice[0]};
  EXPECT_EQ(find_closure(same, yard(3), {}).verdict, ClosureVerdict::kClosed);
}

TEST(ClosureInMap, RefusesRotationallySymmetricHall) {
  std::mt19937 random(1);
  Points hall;
  add_floor(hall, 9.0, random);
  for (const double sign : {1.0, -1.0}) {
    add_wall(hall, -8 * sign, -6 * sign, 8 * sign, -6 * sign, 4.0, random);
    add_wall(hall, 8 * sign, -6 * sign, 8 * sign, 6 * sign, 4.0, random);
    add_wall(hall, 3 * sign, -2 * sign, 5 * sign, 1 * sign, 3.0, random);
  }
  const std::vector<ClosureCandidate> parts = {{Pose::Identity(), hall}};
  EXPECT_EQ(find_closure(parts, hall, {}).verdict, ClosureVerdict::kAmbiguous);
}

TEST(ClosureInMap, GivesUpBeyondItsBudget) {
  const Points there = yard(1);
  const std::vector<ClosureCandidate> parts = {{Pose::Identity(), there}};
  ClosureConfig config;
  config.budget = 1000;
  const ClosureResult result = find_closure(parts, yard(3), config);
  EXPECT_EQ(result.verdict, ClosureVerdict::kOverBudget);
  EXPECT_LT(result.num_expanded, 100 * config.budget);
}

TEST(ClosureCounts, NameReasonShareAndSetting) {
  ClosureCounts counts;
  for (const auto verdict : {ClosureVerdict::kClosed, ClosureVerdict::kPoorFit, ClosureVerdict::kClosed,
                             ClosureVerdict::kPoorFit, ClosureVerdict::kTooFlat}) {
    counts.count(verdict);
  }
  std::vector<Counter> counters;
  counts.append_counters("searches", counters);
  EXPECT_EQ(counters.size(), static_cast<std::size_t>(ClosureVerdict::kClosed)) << "one for each reason";
  std::uint64_t refused = 0;
  for (const Counter& counter : counters) {
    refused += counter.count;
    EXPECT_EQ(counter.of, 5U) << counter.what;
    EXPECT_EQ(counter.what.rfind("searches ", 0), 0U) << counter.what;
  }
  EXPECT_EQ(refused, 3U);
  EXPECT_EQ(counters.back().count, 2U);
  EXPECT_EQ(counters.back().setting, "global.closures.near_min");
}

TEST(Closure, ReportsOverlapAndSurfaceShare) {
  const Points older = yard(1);
  Points newer = yard(2);
  std::mt19937 random(32);
  add_wall(newer, -14, -20, -14, 20, 4.0, random);  // unknown in the older submap
  const ClosureResult result = close_near(older, newer, Pose::Identity(), 3.0);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed);
  EXPECT_LT(result.T_older_newer.translation().norm(), 0.01);
  EXPECT_LT(result.overlap, 0.95);
  ClosureConfig config;
  const auto verdict = [&] { return close_near(older, newer, Pose::Identity(), 3.0, config).verdict; };
  config.overlap_min = result.overlap - 1e-6;
  config.near_min = result.near_share - 1e-6;
  EXPECT_EQ(verdict(), ClosureVerdict::kClosed);
  config.near_min = result.near_share + 1e-6;
  EXPECT_EQ(verdict(), ClosureVerdict::kPoorFit);
  config.overlap_min = result.overlap + 1e-6;
  EXPECT_EQ(verdict(), ClosureVerdict::kLowOverlap);
}

}  // namespace
}  // namespace swiftlet
