// SPDX-License-Identifier: BSD-3-Clause
// Branch-and-bound search compared with exhaustive search: windows, budgets, ties, excluded headings and poses.
#include "core/slam/graph/branch_and_bound.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <set>

#include "swiftlet/core/localization/dead_reckoning.hpp"

namespace swiftlet {
namespace {

using SearchCloud = std::vector<Eigen::Vector3f>;
/// [nodes] Budget that no search of these tests exhausts.
constexpr std::int64_t kNoBudget = 1'000'000'000;
/// [m] Edge of a grid cell.
constexpr double kGridCell_m = 0.5;

SearchCloud random_cloud(std::mt19937& random, int num, float half_m) {
  std::uniform_real_distribution<float> uniform(-half_m, half_m);
  SearchCloud points(static_cast<std::size_t>(num));
  for (Eigen::Vector3f& p : points) {
    for (int axis = 0; axis < 3; ++axis) p(axis) = uniform(random);
  }
  return points;
}

SearchCloud moved_by(const SearchCloud& points, const Vector3& by_m) {
  SearchCloud out = points;
  for (Eigen::Vector3f& p : out) p += by_m.cast<float>();
  return out;
}

std::array<int, 3> grid_cell_of(const Vector3& p_m) {
  const Eigen::Vector3i c = (p_m / kGridCell_m).array().floor().cast<int>();
  return {c.x(), c.y(), c.z()};
}

/// Occupied cells of a map, without a pyramid.
struct SearchedGrid {
  std::set<std::array<int, 3>> occupied;
  explicit SearchedGrid(const SearchCloud& points) {
    for (const Eigen::Vector3f& p : points) occupied.insert(grid_cell_of(p.cast<double>()));
  }
  /// Number of points in occupied cells at the pose T, displaced by whole cells.
  int score(const SearchCloud& cloud, const Pose& T, const std::array<int, 3>& displacement_cells) const {
    int sum = 0;
    for (const Eigen::Vector3f& p : cloud) {
      std::array<int, 3> c = grid_cell_of(T * p.cast<double>());
      for (int axis = 0; axis < 3; ++axis) c[axis] += displacement_cells[axis];
      sum += occupied.count(c) != 0 ? 1 : 0;
    }
    return sum;
  }
};

Pose at_heading(const Pose& T, double yaw_rad) {
  return make_pose(T.translation(), rotation_by({0, 0, yaw_rad}) * Eigen::Quaterniond(T.linear()));
}

double headings_apart_rad(const Pose& a, const Pose& b) {
  const Matrix3 R = a.linear().transpose() * b.linear();
  return std::abs(std::atan2(R(1, 0), R(0, 0)));
}

/// Best pose of the exhaustive search; for equal scores the first.
struct ExhaustiveBest {
  int score = 0;
  Pose T = Pose::Identity();
};

ExhaustiveBest best_by_exhaustive_search(const SearchCloud& map_points, const SearchCloud& cloud, const Pose& guess,
                                         const SearchWindow& window, std::span<const std::uint8_t> allowed,
                                         const Excluded* excluded) {
  const SearchedGrid grid(map_points);
  const int half = static_cast<int>(window.yaw_rad / window.yaw_step_rad + 1e-9);
  ExhaustiveBest best;
  for (int i = -half; i <= half; ++i) {
    if (!allowed.empty() && allowed[static_cast<std::size_t>(i + half)] == 0) continue;
    const Pose T = at_heading(guess, i * window.yaw_step_rad);
    for (int x = -window.xy_cells; x <= window.xy_cells; ++x) {
      for (int y = -window.xy_cells; y <= window.xy_cells; ++y) {
        for (int z = -window.z_cells; z <= window.z_cells; ++z) {
          Pose there = T;
          there.translation() += kGridCell_m * Vector3(x, y, z);
          if (excluded != nullptr && headings_apart_rad(there, excluded->T_map_cloud) <= excluded->angle_rad &&
              (there.translation() - excluded->T_map_cloud.translation()).norm() < excluded->distance_m) {
            continue;
          }
          const int score = grid.score(cloud, T, {x, y, z});
          if (score > best.score) best = {score, there};
        }
      }
    }
  }
  return best;
}

TEST(GridPyramid, HoldsPointCellsAtLowestLevel) {
  std::mt19937 random(11);
  const SearchCloud points = moved_by(random_cloud(random, 80, 3.0F), {4.0, -7.0, 1.0});
  const SearchedGrid grid(points);
  for (const int levels : {1, 3}) {
    const OccupancyPyramid pyramid(points, kGridCell_m, levels);
    for (int x = -5; x < 20; ++x) {
      for (int y = -28; y < 2; ++y) {
        for (int z = -12; z < 16; ++z) ASSERT_EQ(pyramid.at(0, x, y, z), grid.occupied.count({x, y, z}) != 0);
      }
    }
  }
  EXPECT_FALSE(OccupancyPyramid({}, kGridCell_m, 3).at(2, 0, 0, 0)) << "without points, no cell is occupied";
}

TEST(GridSearchWindow, SpansHeadingsAroundTheGuess) {
  const SearchWindow window{5, 2, 0.1, 0.04};
  ASSERT_EQ(num_yaws(window), 5);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(yaw_offset_rad(window, i), 0.04 * (i - 2), 1e-15);
  EXPECT_EQ(num_yaws({5, 2, 0.119, 0.04}), 5);
  EXPECT_EQ(num_yaws({5, 2, 0.121, 0.04}), 7);
  EXPECT_EQ(num_yaws({5, 2, 0.0, 0.04}), 1);
}

TEST(BranchAndBound, FindsBestPoseAroundAnyGuess) {
  std::mt19937 random(12);
  const SearchWindow window{4, 1, 0.31, 0.1};
  for (int trial = 0; trial < 12; ++trial) {
    const SearchCloud points = random_cloud(random, 60, 4.0F);
    const Pose T = make_pose({0.6, -1.2, 0.3}, rotation_by({0, 0, 0.2}));
    SearchCloud cloud;
    for (const Eigen::Vector3f& p : points) cloud.push_back((T.inverse() * p.cast<double>()).cast<float>());
    cloud.resize(30);
    const Pose guess = make_pose({1.3, -0.4, 0.1}, rotation_by({0.02, -0.01, 0.05}));
    std::vector<std::uint8_t> allowed;
    if (trial % 3 == 1) allowed = {1, 1, 1, 1, 0, 0, 0};
    if (trial % 3 == 2) allowed = {0, 0, 0, 0, 0, 1, 0};
    const Excluded near{T, 1.2, trial % 2 == 0 ? 7.0 : 0.12};
    const Excluded* excluded = trial < 3 ? nullptr : &near;
    const OccupancyPyramid map(points, kGridCell_m, 1 + trial % 4);
    const SearchResult found = search_best_pose(map, cloud, guess, window, 0.0, kNoBudget, allowed, excluded);
    const ExhaustiveBest expected = best_by_exhaustive_search(points, cloud, guess, window, allowed, excluded);
    ASSERT_TRUE(found.complete);
    ASSERT_TRUE(found.best);
    EXPECT_DOUBLE_EQ(found.best->score, expected.score / 30.0) << trial;
    // The reported share of points lies in occupied cells at the reported pose.
    const Vector3 by_m = found.best->T_map_cloud.translation() - guess.translation();
    const Pose turned = make_pose(guess.translation(), Eigen::Quaterniond(found.best->T_map_cloud.linear()));
    const Eigen::Vector3i displacement_cells = (by_m / kGridCell_m).array().round().cast<int>();
    EXPECT_LT((by_m - kGridCell_m * displacement_cells.cast<double>()).norm(), 1e-9);
    EXPECT_EQ(SearchedGrid(points).score(cloud, turned,
                                         {displacement_cells.x(), displacement_cells.y(), displacement_cells.z()}),
              expected.score)
        << trial;
    if (excluded != nullptr && headings_apart_rad(found.best->T_map_cloud, T) <= near.angle_rad) {
      EXPECT_GE((found.best->T_map_cloud.translation() - T.translation()).norm(), near.distance_m);
    }
  }
}

TEST(BranchAndBound, SearchesExactlyWithinItsWindow) {
  std::mt19937 random(13);
  const SearchCloud points = random_cloud(random, 40, 5.0F);
  for (int levels = 1; levels <= 4; ++levels) {
    const OccupancyPyramid map(points, kGridCell_m, levels);
    for (const int xy : {4, 5}) {
      const SearchWindow window{xy, 2, 0.0, 0.05};
      for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {-1, 1}) {
          const int edge = axis == 2 ? 2 : xy;
          const auto best_at = [&](int cells) {
            const SearchCloud cloud = moved_by(points, -kGridCell_m * side * cells * Vector3::Unit(axis));
            const SearchResult found = search_best_pose(map, cloud, Pose::Identity(), window, 0.0, kNoBudget);
            return found.best ? found.best->score : 0.0;
          };
          EXPECT_EQ(best_at(edge), 1.0) << levels << " " << axis << " " << side;
          EXPECT_LT(best_at(edge + 1), 1.0) << levels << " " << axis << " " << side;
        }
      }
    }
  }
}

TEST(BranchAndBound, ReturnsFirstOfEqualPoses) {
  // The map has two points, the cloud one: displacements to either point have the highest score.
  for (int axis = 0; axis < 3; ++axis) {
    SearchCloud posts;
    for (const double at_m : {-1.0, 1.0}) posts.push_back((at_m * Vector3::Unit(axis)).cast<float>());
    const SearchCloud cloud = {Eigen::Vector3f::Zero()};
    for (int levels = 1; levels <= 2; ++levels) {
      const SearchResult found = search_best_pose(OccupancyPyramid(posts, kGridCell_m, levels), cloud, Pose::Identity(),
                                                  {3, 3, 0.0, 0.05}, 0.0, kNoBudget);
      ASSERT_TRUE(found.best);
      EXPECT_EQ(found.best->T_map_cloud.translation(), -Vector3::Unit(axis)) << axis << " " << levels;
    }
  }
  // A point near the axis of rotation stays in its cell at every heading of the window.
  const SearchCloud post = {{0.1F, 0.1F, 0.0F}};
  const SearchResult found = search_best_pose(OccupancyPyramid(post, kGridCell_m, 1), post, Pose::Identity(),
                                              {0, 0, 0.1, 0.05}, 0.0, kNoBudget);
  ASSERT_TRUE(found.best);
  EXPECT_NEAR(yaw_of(found.best->T_map_cloud.linear()), -0.1, 1e-12);
}

TEST(BranchAndBound, EndsExactlyAtItsBudget) {
  const SearchCloud post = {{0.1F, 0.1F, 0.1F}};
  const OccupancyPyramid map(post, kGridCell_m, 1);
  const auto complete = [&](std::int64_t budget) {
    return search_best_pose(map, post, Pose::Identity(), {3, 2, 0.0, 0.05}, 0.0, budget).complete;
  };
  EXPECT_TRUE(complete(7 * 7 * 5));
  EXPECT_FALSE(complete(7 * 7 * 5 - 1));
}

TEST(BranchAndBound, AcceptsScoresFromTheMinimumUpward) {
  // The map has the cells of three of the cloud's eight points.
  SearchCloud points, cloud;
  for (int i = 0; i < 8; ++i) cloud.emplace_back(1.5F * static_cast<float>(i), 0.1F, 0.1F);
  for (int i = 0; i < 3; ++i) points.push_back(cloud[static_cast<std::size_t>(i * i)]);
  const OccupancyPyramid map(points, kGridCell_m, 1);
  const auto found = [&](double score_min) {
    return search_best_pose(map, cloud, Pose::Identity(), {0, 0, 0.0, 0.05}, score_min, kNoBudget).best;
  };
  for (const double score_min : {0.0, 0.3, 3.0 / 8.0}) {
    ASSERT_TRUE(found(score_min)) << score_min;
    EXPECT_DOUBLE_EQ(found(score_min)->score, 3.0 / 8.0);
  }
  for (const double score_min : {3.01 / 8.0, 4.0 / 8.0, 1.0}) EXPECT_FALSE(found(score_min)) << score_min;
  // With a minimum score of 0, one matching point gives a result; without any there is none.
  const SearchCloud one = {cloud[0]};
  EXPECT_TRUE(search_best_pose(OccupancyPyramid(one, kGridCell_m, 1), cloud, Pose::Identity(), {0, 0, 0.0, 0.05}, 0.0,
                               kNoBudget)
                  .best);
  EXPECT_FALSE(search_best_pose(OccupancyPyramid(one, kGridCell_m, 1), moved_by(cloud, {0, 9, 0}), Pose::Identity(),
                                {0, 0, 0.0, 0.05}, 0.0, kNoBudget)
                   .best);
  EXPECT_FALSE(search_best_pose(map, {}, Pose::Identity(), {0, 0, 0.0, 0.05}, 0.0, kNoBudget).best);
}

TEST(RotationalHistogram, AcceptsAnyHeadingWithoutSurfaces) {
  std::mt19937 random(16);
  const RotationalHistogram none({}), some(random_cloud(random, 60, 1.5F));
  EXPECT_EQ(none.similarity(none, 0.3), 1.0);
  EXPECT_EQ(none.similarity(some, 0.3), 1.0);
  EXPECT_EQ(some.similarity(none, 0.3), 1.0);
}

}  // namespace
}  // namespace swiftlet
