// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/slam/closure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/slam/branch_and_bound.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"
#include "swiftlet/core/slam/scan_to_map.hpp"
#include "swiftlet/core/slam/surface_map.hpp"

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

/// A yard of walls that stand in no regular way.
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

TEST(OccupancyPyramid, EveryLevelIsTheMaximumOverItsCells) {
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

/// Every displacement and heading, one by one.
double best_by_force(const OccupancyPyramid& map, const Points& points, const Pose& guess, const SearchWindow& window,
                     const Excluded* excluded) {
  int best = 0;
  for (int i = 0; i < num_yaws(window); ++i) {
    Pose T = guess;
    T.linear() = rotation_by({0, 0, yaw_offset_rad(window, i)}).toRotationMatrix() * guess.linear();
    for (int x = -window.xy_cells; x <= window.xy_cells; ++x) {
      for (int y = -window.xy_cells; y <= window.xy_cells; ++y) {
        for (int z = -window.z_cells; z <= window.z_cells; ++z) {
          const Vector3 by = map.cell_m() * Vector3(x, y, z);
          if (excluded != nullptr &&
              (T.translation() + by - excluded->T_map_cloud.translation()).norm() < excluded->distance_m) {
            continue;
          }
          int score = 0;
          for (const Eigen::Vector3f& p : points) {
            const Eigen::Vector3i c = ((T * p.cast<double>()) / map.cell_m()).array().floor().cast<int>();
            score += map.at(0, c.x() + x, c.y() + y, c.z() + z) ? 1 : 0;
          }
          best = std::max(best, score);
        }
      }
    }
  }
  return static_cast<double>(best) / static_cast<double>(points.size());
}

TEST(BranchAndBound, NeverMissesTheBestPoseInTheWindow) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> uniform(-5.0F, 5.0F);
  std::int64_t expanded = 0, leaves = 0;
  for (int trial = 0; trial < 8; ++trial) {
    Points points(40);
    for (Eigen::Vector3f& p : points) {
      for (int axis = 0; axis < 3; ++axis) p(axis) = uniform(random);
    }
    const Pose T = make_pose({0.7, -1.1, 0.4}, rotation_by({0, 0, 0.11}));
    Points moved_points = seen_from(points, T);
    for (Eigen::Vector3f& p : moved_points) p += 0.1F * Eigen::Vector3f(uniform(random), 0.0F, 0.0F);
    const OccupancyPyramid map(points, 0.5, 1 + trial % 4);
    const SearchWindow window{5, 2, 0.1, 0.05};
    const Excluded excluded{T, 1.0};
    for (const Excluded* without : {static_cast<const Excluded*>(nullptr), &excluded}) {
      const SearchResult found =
          search_best_pose(map, moved_points, Pose::Identity(), window, 0.0, 1'000'000'000, {}, without);
      ASSERT_TRUE(found.complete);
      ASSERT_TRUE(found.best);
      EXPECT_DOUBLE_EQ(found.best->score, best_by_force(map, moved_points, Pose::Identity(), window, without));
      if (trial % 4 == 3 && without == nullptr) {
        expanded += found.num_expanded;
        leaves += 11 * 11 * 5 * num_yaws(window);
      }
    }
  }
  EXPECT_LT(expanded, leaves) << "bounds save work";
}

TEST(BranchAndBound, TheEdgesOfTheWindowBelongToIt) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-5.0F, 5.0F);
  Points points(40);
  for (Eigen::Vector3f& p : points) {
    for (int axis = 0; axis < 3; ++axis) p(axis) = uniform(random);
  }
  const OccupancyPyramid map(points, 0.5, 3);
  const SearchWindow window{5, 2, 0.0, 0.05};
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      const Vector3 off_m = 0.5 * side * (axis == 2 ? 2 : 5) * Vector3::Unit(axis);
      Points moved_points = points;
      for (Eigen::Vector3f& p : moved_points) p -= off_m.cast<float>();
      const SearchResult found = search_best_pose(map, moved_points, Pose::Identity(), window, 0.0, 1'000'000'000);
      ASSERT_TRUE(found.best);
      EXPECT_EQ(found.best->score, 1.0) << axis << " " << side;
      EXPECT_EQ(found.best->T_map_cloud.translation(), off_m);
    }
  }
}

TEST(BranchAndBound, TellsWhenItsBudgetEnds) {
  const Points points = upright_points_m(yard(1), 0.5, 25.0);
  const OccupancyPyramid map(points, 0.5, 4);
  const SearchResult found = search_best_pose(map, points, Pose::Identity(), {10, 2, 0.2, 0.02}, 0.1, 50);
  EXPECT_FALSE(found.complete);
  EXPECT_LT(found.num_expanded, 400);
}

TEST(RotationalHistogram, AgreesAtTheRightHeadingAndNotAtAnother) {
  const Points points = yard(1);
  const RotationalHistogram map(points);
  const RotationalHistogram turned(seen_from(points, make_pose({0, 0, 0}, rotation_by({0, 0, 0.4}))));
  EXPECT_GT(turned.similarity(map, 0.4), 0.85);
  EXPECT_LT(turned.similarity(map, 0.0), 0.6);
}

TEST(Closure, FindsAKnownRelativePoseToACentimeter) {
  const Points older = yard(1);
  for (const double yaw_rad : {0.3, -2.0}) {
    const Pose T = make_pose({1.5, -0.8, 0.3}, rotation_by({0, 0, yaw_rad}));
    const Points newer = seen_from(yard(2), T);
    const Pose guess = make_pose(T.translation() + Vector3(-1.6, 1.2, -0.4), rotation_by({0, 0, yaw_rad + 0.08}));
    const ClosureResult result = find_closure(older, newer, guess, {});
    ASSERT_EQ(result.verdict, ClosureVerdict::kClosed) << static_cast<int>(result.verdict) << " " << result.score;
    const Pose off = T.inverse() * result.T_older_newer;
    EXPECT_LT(off.translation().norm(), 0.01);
    EXPECT_LT(rotation_vector_rad(Eigen::Quaterniond(Matrix3(off.linear()))).norm(), 0.002);
    EXPECT_GT(result.near_share, 0.9);
  }
}

TEST(Closure, RefusesAislesThatLookAlike) {
  const Pose T = make_pose({0.2, 0.3, 0.1}, rotation_by({0, 0, 0.02}));
  const ClosureResult result = find_closure(aisles(1), seen_from(aisles(2), T), Pose::Identity(), {});
  EXPECT_EQ(result.verdict, ClosureVerdict::kRival);
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

// The newer submap goes on where the older one ends. A bay off, more of it lies on racks.
TEST(Closure, ABayOffIsRefusedThoughItScoresBest) {
  const Points older = bays(-15.0, 10.0, 1), newer = bays(-9.0, 16.0, 2);
  ClosureConfig config;
  const ClosureResult result =
      find_closure(older, newer, make_pose({0.2, 0.1, 0}, rotation_by({0, 0, 0})), config, 1e9);
  EXPECT_EQ(result.verdict, ClosureVerdict::kRival) << "score " << result.score;
}

// The next bay is farther away than the guess can be off, so the right one is taken, although it scores less.
TEST(Closure, ABayOffIsNotLookedAtWhereTheGuessIsNearer) {
  const Points older = bays(-15.0, 10.0, 1), newer = bays(-9.0, 16.0, 2);
  const ClosureResult result =
      find_closure(older, newer, make_pose({0.2, 0.1, 0}, rotation_by({0, 0, 0})), ClosureConfig{}, 0.5);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed) << "score " << result.score;
  EXPECT_LT(result.T_older_newer.translation().norm(), 0.02);
}

// Seen from the same place, the right bay scores best. The next one fits as well, but the vehicle knows better.
TEST(Closure, ABayOffDoesNotCountWhereTheVehicleKnowsBetter) {
  const Points older = bays(-15.0, 15.0, 1), newer = bays(-15.0, 15.0, 2);
  ClosureConfig config;
  config.rival_share = 1.0;
  const Pose guess = make_pose({0.0, 0.1, 0}, rotation_by({0, 0, 0}));
  EXPECT_EQ(find_closure(older, newer, guess, config, 1e9).verdict, ClosureVerdict::kRival);
  const ClosureResult result = find_closure(older, newer, guess, config, 1.0);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed);
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

// Nobody can tell how far it is along the wall. All else is told as exactly as by a whole yard.
TEST(Closure, ANearlyRightGuessIsClosedButForTheWayAlongASingleWall) {
  const Pose T = make_pose({0.0, 0.2, -0.15}, rotation_by({0, 0, 0.01}));
  const ClosureResult result =
      find_closure(floor_and_wall(1), seen_from(floor_and_wall(2), T), Pose::Identity(), ClosureConfig{}, 0.5);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed) << static_cast<int>(result.verdict);
  const Pose off = T.inverse() * result.T_older_newer;
  EXPECT_LT(off.translation().tail<2>().norm(), 0.01);
  EXPECT_LT(std::abs(result.T_older_newer.translation().x()), 0.05) << "the guess is kept";
  EXPECT_LT(rotation_vector_rad(Eigen::Quaterniond(Matrix3(off.linear()))).norm(), 0.002);
  EXPECT_LT((result.told * Vector6::Unit(0)).norm(), 0.05);
  for (const int axis : {1, 2, 3, 4, 5}) {
    EXPECT_LT((result.told * Vector6::Unit(axis) - Vector6::Unit(axis)).head<3>().norm(), 0.5) << axis;
    EXPECT_LT((result.told * Vector6::Unit(axis) - Vector6::Unit(axis)).tail<3>().norm(), 0.02) << axis;
  }
  EXPECT_LT((result.told * result.told - result.told).norm(), 1e-9) << "a projector";
}

/// The same, and fins of 0.5 m across the wall.
Points wall_with_fins(unsigned seed, std::span<const double> fins_x_m) {
  Points points = floor_and_wall(seed);
  std::mt19937 random(seed + 100);
  for (const double x_m : fins_x_m) add_wall(points, x_m, 3.5, x_m, 4.0, 4.0, random);
  return points;
}

// From the guess no fin is in reach.
TEST(Closure, AGuessThatIsOffAlongAWallSlidesToWhereItFits) {
  const double fins_x_m[] = {-7.4, -4.1, -3.0, 1.2, 2.9, 6.6};
  const Pose T = make_pose({0.58, 0.1, -0.05}, rotation_by({0, 0, 0.005}));
  const ClosureResult result = find_closure(wall_with_fins(1, fins_x_m), seen_from(wall_with_fins(2, fins_x_m), T),
                                            Pose::Identity(), ClosureConfig{}, 0.6);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed) << static_cast<int>(result.verdict);
  EXPECT_LT((T.inverse() * result.T_older_newer).translation().norm(), 0.01);
  EXPECT_TRUE(result.told.isIdentity());
}

// A fin and ribs tell where it is to a millimeter. But the ribs are regular, and one fin is little. So it fits at the
// next ribs about as well, and nothing is told of the way along the wall.
TEST(Closure, WhatFitsAtTheNextRibsTellsNothingOfTheWayAlongTheWall) {
  const auto ribbed = [](unsigned seed) {
    const double fin_x_m[] = {-7.4};
    Points points = wall_with_fins(seed, fin_x_m);
    std::mt19937 random(seed + 200);
    for (int i = -39; i <= 39; ++i) add_wall(points, 0.3 * i, 3.8, 0.3 * i, 4.0, 0.6, random);
    return points;
  };
  const Pose T = make_pose({0.3, 0.1, -0.05}, rotation_by({0, 0, 0.005}));
  const ClosureResult result = find_closure(ribbed(1), seen_from(ribbed(2), T), Pose::Identity(), ClosureConfig{}, 0.6);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed) << static_cast<int>(result.verdict);
  EXPECT_LT((T.inverse() * result.T_older_newer).translation().norm(), 0.01);
  EXPECT_LT((result.told * Vector6::Unit(0)).norm(), 0.05);
  for (const int axis : {1, 2}) EXPECT_GT((result.told * Vector6::Unit(axis)).norm(), 0.9) << axis;
}

TEST(Closure, AFloorAloneLeavesTooMuchOpenHoweverRightTheGuess) {
  std::mt19937 random(6);
  Points floor;
  add_floor(floor, 12.0, random);
  EXPECT_NE(find_closure(floor, floor, Pose::Identity(), ClosureConfig{}, 0.5).verdict, ClosureVerdict::kClosed);
}

TEST(Closure, FartherThanTheGuessCanBeOffNothingIsClosed) {
  const Pose T = make_pose({0.9, 0.2, 0.1}, rotation_by({0, 0, 0.02}));
  const Points older = yard(1), newer = seen_from(yard(2), T);
  EXPECT_EQ(find_closure(older, newer, Pose::Identity(), ClosureConfig{}, 0.7).verdict, ClosureVerdict::kMoved);
  EXPECT_NE(find_closure(older, newer, Pose::Identity(), ClosureConfig{}, 0.4).verdict, ClosureVerdict::kClosed);
  const ClosureResult result = find_closure(older, newer, Pose::Identity(), ClosureConfig{}, 1.0);
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed);
  EXPECT_TRUE(result.told.isIdentity());
  EXPECT_LT((T.inverse() * result.T_older_newer).translation().norm(), 0.01);
}

// As high as the next shelf is the view much the same. A search would have taken it where more of the points meet
// cells of its grid.
TEST(Closure, ANearlyRightGuessKeepsTheShelf) {
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
      find_closure(shelves(0.0, 4.2, 1), seen_from(shelves(0.6, 5.0, 2), T), Pose::Identity(), ClosureConfig{}, 0.4);
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
  EXPECT_NE(find_closure(yard(1), other, Pose::Identity(), {}).verdict, ClosureVerdict::kClosed);
}

TEST(Closure, RefusesABareFloorAndASingleWall) {
  std::mt19937 random(6);
  Points floor;
  add_floor(floor, 12.0, random);
  EXPECT_EQ(find_closure(floor, floor, Pose::Identity(), {}).verdict, ClosureVerdict::kTooFlat);
  Points wall = floor;
  add_wall(wall, -12, 4, 12, 4, 4.0, random);
  const ClosureVerdict verdict = find_closure(wall, wall, Pose::Identity(), {}).verdict;
  EXPECT_TRUE(verdict == ClosureVerdict::kRival || verdict == ClosureVerdict::kOpen) << static_cast<int>(verdict);
}

TEST(FindInMap, FindsTheSubmapTheHeadingAndThePlaceWithoutAnyGuess) {
  const Points first = yard(1), second = seen_from(yard(2), make_pose({4, -3, 0.5}, rotation_by({0, 0, 0.7})));
  Points far(first.size(), Eigen::Vector3f::Zero());
  for (std::size_t i = 0; i < far.size(); ++i) far[i] = {first[i].y() * 0.6F, first[i].x() * 0.8F, first[i].z()};
  const std::vector<MapPart> parts = {
      {make_pose({100, 0, 0}, Eigen::Quaterniond::Identity()), far},
      {make_pose({4, -3, 0.5}, rotation_by({0, 0, 0.7})), second},
  };
  const Pose T_map_cloud = make_pose({1.5, -1.0, 0.9}, rotation_by({0, 0, -2.2}));
  const MapMatch match = find_in_map(parts, seen_from(yard(3), T_map_cloud), global_closure_config());
  ASSERT_EQ(match.result.verdict, ClosureVerdict::kClosed);
  EXPECT_EQ(match.part, 1U);
  const Pose off = T_map_cloud.inverse() * parts[1].T_map_part * match.result.T_older_newer;
  EXPECT_LT(off.translation().norm(), 0.02);
  EXPECT_LT(rotation_vector_rad(Eigen::Quaterniond(Matrix3(off.linear()))).norm(), 0.003);
}

TEST(FindInMap, TakesNothingWhereTwoPlacesLookAlike) {
  const Points there = yard(1);
  const std::vector<MapPart> twice = {
      {Pose::Identity(), there},
      {make_pose({100, 0, 0}, Eigen::Quaterniond::Identity()), there},
  };
  EXPECT_EQ(find_in_map(twice, yard(3), global_closure_config()).result.verdict, ClosureVerdict::kRival);
  // The same submap twice at the same place is one place.
  const std::vector<MapPart> same = {twice[0], twice[0]};
  EXPECT_EQ(find_in_map(same, yard(3), global_closure_config()).result.verdict, ClosureVerdict::kClosed);
}

TEST(FindInMap, TakesNothingInAHallThatLooksTheSameTurnedAround) {
  std::mt19937 random(1);
  Points hall;
  add_floor(hall, 9.0, random);
  for (const double sign : {1.0, -1.0}) {
    add_wall(hall, -8 * sign, -6 * sign, 8 * sign, -6 * sign, 4.0, random);
    add_wall(hall, 8 * sign, -6 * sign, 8 * sign, 6 * sign, 4.0, random);
    add_wall(hall, 3 * sign, -2 * sign, 5 * sign, 1 * sign, 3.0, random);
  }
  const std::vector<MapPart> parts = {{Pose::Identity(), hall}};
  EXPECT_EQ(find_in_map(parts, hall, global_closure_config()).result.verdict, ClosureVerdict::kRival);
}

TEST(Closure, UprightIsAColumnInWhichSomethingStandsAMeterHigh) {
  std::mt19937 random(31);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  for (const double cell_m : {0.5, 0.3}) {
    Points points;
    for (int i = 0; i < 1200; ++i) {
      const float x = 9.0F * uniform(random), y = 9.0F * uniform(random), z = uniform(random);
      points.emplace_back(x, y, z);
    }
    const double range_m = 7.0;
    // A point is in when any two of its column are a meter apart; of each cube the first.
    const auto column_of = [&](const Eigen::Vector3f& p) {
      return std::pair(std::floor(p.x() / cell_m), std::floor(p.y() / cell_m));
    };
    Points upright;
    for (const Eigen::Vector3f& p : points) {
      if (std::hypot(p.x(), p.y()) > range_m) continue;
      float low = p.z(), high = p.z();
      for (const Eigen::Vector3f& other : points) {
        if (std::hypot(other.x(), other.y()) > range_m || column_of(other) != column_of(p)) continue;
        low = std::min(low, other.z());
        high = std::max(high, other.z());
      }
      if (high - low < 1.0F) continue;
      const auto in_its_cube = [&](const Eigen::Vector3f& q) {
        return column_of(q) == column_of(p) && std::floor(q.z() / cell_m) == std::floor(p.z() / cell_m);
      };
      if (std::none_of(upright.begin(), upright.end(), in_its_cube)) upright.push_back(p);
    }
    EXPECT_EQ(upright_points_m(points, cell_m, range_m), upright);
    EXPECT_GT(upright.size(), 25U);
  }
}

/// So many posts of two points, 1.2 m above each other.
Points posts(int num) {
  Points points;
  for (int i = 0; i < num; ++i) {
    const float a = 2.4F * static_cast<float>(i), r = 1.0F + 0.2F * static_cast<float>(i);
    points.emplace_back(r * std::cos(a), r * std::sin(a), 0.1F);
    points.emplace_back(r * std::cos(a), r * std::sin(a), 1.3F);
  }
  return points;
}

TEST(Closure, FewerThanFortyUprightPointsTellNothing) {
  for (const int num : {19, 20}) {
    const bool flat = num == 19;
    ASSERT_EQ(upright_points_m(posts(num), 0.5, 25.0).size(), static_cast<std::size_t>(2 * num));
    EXPECT_EQ(find_closure(posts(num), posts(30), Pose::Identity(), {}).verdict == ClosureVerdict::kTooFlat, flat);
    EXPECT_EQ(find_closure(posts(30), posts(num), Pose::Identity(), {}).verdict == ClosureVerdict::kTooFlat, flat);
    const Points part = posts(30), few = posts(num);
    ClosureConfig config = global_closure_config();
    config.window_xy_m = config.window_z_m = 0.5;
    config.window_yaw_deg = 1.0;
    EXPECT_EQ(find_in_map(std::vector<MapPart>{{Pose::Identity(), part}}, few, config).result.verdict ==
                  ClosureVerdict::kTooFlat,
              flat);
    // A part of a map of which that is true is no place.
    EXPECT_EQ(find_in_map(std::vector<MapPart>{{Pose::Identity(), few}}, part, config).result.num_expanded == 0, flat);
  }
}

/// Without bounds every place in the window is looked at once.
ClosureConfig one_by_one() {
  ClosureConfig config;
  config.levels = 1;
  config.histogram_min = 0.0;
  config.budget = 100000000;
  config.points = 60;
  return config;
}

TEST(Closure, TheWindowIsAsLargeAsItIsToldAndItsHeadingsAreAsFineAsTheFarthestPointAsks) {
  const Points older = posts(30), newer = posts(40);
  for (const double range_m : {25.0, 12.0}) {
    ClosureConfig config = one_by_one();
    config.range_max_m = range_m;
    config.window_xy_m = 1.2;
    config.window_z_m = 0.6;
    config.window_yaw_deg = 8.0;
    config.score_min = 1.0;  // which nothing reaches: one search
    const ClosureResult result = find_closure(older, newer, Pose::Identity(), config);
    ASSERT_EQ(result.verdict, ClosureVerdict::kNoMatch);
    // Turned by a step, the farthest point moves by a hundredth less than a cell, along its chord.
    const double step_deg = 0.99 * 2.0 * std::asin(0.5 * 0.5 / range_m) * 180.0 / M_PI;
    const int headings = 2 * static_cast<int>(8.0 / step_deg) + 1;
    EXPECT_EQ(result.num_expanded, 7 * 7 * 5 * headings) << range_m;
    config.score_min = 0.0;
    config.budget = 100;
    EXPECT_EQ(find_closure(older, newer, Pose::Identity(), config).verdict, ClosureVerdict::kNotSearched);
  }
}

TEST(Closure, OnlyHeadingsWhoseHistogramsAgreeAreSearched) {
  const Points older = yard(1);
  const Pose T = make_pose({0.3, 0.2, 0.0}, rotation_by({0, 0, 0.5}));
  const Points newer = seen_from(yard(2), T);
  const Pose guess = make_pose({0, 0, 0}, rotation_by({0, 0, 0.5 - 0.1}));
  ClosureConfig config = one_by_one();
  config.window_xy_m = config.window_z_m = 0.5;
  const RotationalHistogram of_older(older), of_newer(newer);
  config.histogram_min = of_newer.similarity(of_older, 0.5) - 0.1;
  const SearchWindow window{1, 1, 8.0 * M_PI / 180.0, 0.99 * 2.0 * std::asin(0.5 * 0.5 / 25.0)};
  int likely = 0, mirrored = 0;
  for (int i = 0; i < num_yaws(window); ++i) {
    const double offset_rad = yaw_offset_rad(window, i);
    likely += of_newer.similarity(of_older, 0.4 + offset_rad) >= config.histogram_min;
    mirrored += of_newer.similarity(of_older, 0.4 - offset_rad) >= config.histogram_min && offset_rad > 0.07;
  }
  ASSERT_GT(likely, 0);
  ASSERT_LT(likely, num_yaws(window));
  ASSERT_EQ(mirrored, 0) << "otherwise this test shows less";
  const ClosureResult result = find_closure(older, newer, guess, config);
  EXPECT_EQ(result.verdict, ClosureVerdict::kClosed);
  EXPECT_EQ(result.num_expanded, 3 * 3 * 3 * 3 * likely) << "for the best, and twice for its rivals";
  config.histogram_min = 1.0;
  EXPECT_EQ(find_closure(older, newer, guess, config).num_expanded, 0);
}

TEST(Closure, TellsHowMuchOfItIsKnownAndHowMuchOfThatLiesOnSurfaces) {
  const Points older = yard(1);
  Points newer = yard(2);
  std::mt19937 random(32);
  add_wall(newer, -14, -20, -14, 20, 4.0, random);  // what the older one does not know
  const ClosureResult result = find_closure(older, newer, Pose::Identity(), {});
  ASSERT_EQ(result.verdict, ClosureVerdict::kClosed);
  EXPECT_LT(result.T_older_newer.translation().norm(), 0.01);
  SurfaceMap surfaces{SurfaceMapConfig{}};
  std::vector<Vector3> points;
  for (const Eigen::Vector3f& p : older) points.push_back(p.cast<double>());
  surfaces.insert(points, Vector3::Zero());
  ScanToMapConfig of_submaps;
  of_submaps.surface_sigma_m = 0.01;
  const ScanFit fit = fit_scan(surfaces, newer, result.T_older_newer, of_submaps);
  EXPECT_NEAR(result.overlap, static_cast<double>(fit.num_known) / static_cast<double>(newer.size()), 1e-12);
  EXPECT_NEAR(result.near_share, static_cast<double>(fit.num_near) / fit.num_known, 1e-12);
  EXPECT_LT(result.overlap, 0.95);
  ClosureConfig config;
  const auto verdict = [&] { return find_closure(older, newer, Pose::Identity(), config).verdict; };
  config.overlap_min = result.overlap - 1e-6;
  config.near_min = result.near_share - 1e-6;
  EXPECT_EQ(verdict(), ClosureVerdict::kClosed);
  config.near_min = result.near_share + 1e-6;
  EXPECT_EQ(verdict(), ClosureVerdict::kDoesNotFit);
  config.overlap_min = result.overlap + 1e-6;
  EXPECT_EQ(verdict(), ClosureVerdict::kNoOverlap);
}

TEST(Closure, ARefinementThatLeavesThePlaceIsRefused) {
  const Points older = yard(1);
  ClosureConfig config;
  config.window_xy_m = config.window_z_m = config.window_yaw_deg = 0.0;
  config.score_min = config.rival_share = config.histogram_min = 0.0;
  config.rival_distance_m = 10.0;
  const auto verdict = [&](const Vector3& off_m, double off_deg) {
    const Pose guess = make_pose(off_m, rotation_by({0, 0, off_deg * M_PI / 180.0}));
    return find_closure(older, yard(2), guess, config).verdict;
  };
  EXPECT_EQ(verdict({0, 0, 0}, 3.5), ClosureVerdict::kClosed);
  EXPECT_EQ(verdict({0, 0, 0}, 4.6), ClosureVerdict::kMoved);
  // Heights are tried up to a cell above and below.
  config.cell_m = 0.9;
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_EQ(verdict({0, 0, sign * 0.9}, 0.0), ClosureVerdict::kClosed) << sign;
    EXPECT_EQ(verdict({0, 0, sign * 0.45}, 0.0), ClosureVerdict::kClosed) << sign;
  }
  config.cell_m = 1.2;
  EXPECT_EQ(verdict({0, 0, 1.2}, 0.0), ClosureVerdict::kMoved);
}

TEST(FindInMap, AnotherHeadingAtTheSamePlaceIsARivalFromTwentyDegreesOn) {
  // The part has a yard twice, turned by some degrees; the cloud has it once.
  const Points once = yard(1);
  ClosureConfig config = global_closure_config();
  config.window_xy_m = config.window_z_m = 0.5;
  config.window_yaw_deg = 40.0;
  config.histogram_min = 0.0;
  config.near_min = 0.3;
  for (const double apart_deg : {15.0, 25.0}) {
    Points twice = once;
    for (const Eigen::Vector3f& p :
         seen_from(once, make_pose({0, 0, 0}, rotation_by({0, 0, apart_deg * M_PI / 180.0})))) {
      twice.push_back(p);
    }
    const auto verdict = find_in_map(std::vector<MapPart>{{Pose::Identity(), twice}}, once, config).result.verdict;
    EXPECT_EQ(verdict == ClosureVerdict::kRival, apart_deg > 20.0) << apart_deg << " " << static_cast<int>(verdict);
  }
}

}  // namespace
}  // namespace swiftlet
