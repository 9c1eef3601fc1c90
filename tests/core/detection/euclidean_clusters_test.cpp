// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/euclidean_clusters.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

using Points = std::vector<Eigen::Vector3f>;

/// Every pair, then flooding: the definition.
std::vector<std::vector<std::uint32_t>> by_brute_force(const Points& points, float tolerance_m) {
  std::vector<std::vector<std::uint32_t>> clusters;
  std::vector<bool> done(points.size(), false);
  for (std::uint32_t seed = 0; seed < points.size(); ++seed) {
    if (done[seed] || !points[seed].allFinite()) continue;
    std::vector<std::uint32_t> cluster = {seed};
    done[seed] = true;
    for (std::size_t k = 0; k < cluster.size(); ++k) {
      for (std::uint32_t j = 0; j < points.size(); ++j) {
        if (done[j] || !((points[cluster[k]] - points[j]).squaredNorm() <= tolerance_m * tolerance_m)) continue;
        done[j] = true;
        cluster.push_back(j);
      }
    }
    std::sort(cluster.begin(), cluster.end());
    clusters.push_back(cluster);
  }
  return clusters;
}

std::vector<std::vector<std::uint32_t>> by_us(EuclideanClusters& clusters, const Points& points, double tolerance_m) {
  clusters.compute(points, tolerance_m);
  std::vector<std::vector<std::uint32_t>> out;
  for (int c = 0; c < clusters.size(); ++c) out.emplace_back(clusters.members(c).begin(), clusters.members(c).end());
  return out;
}

TEST(EuclideanClusters, AreThoseOfBruteForce) {
  EuclideanClusters clusters;
  for (std::uint32_t trial = 0; trial < 60; ++trial) {
    const Random random(trial, "test.clusters");
    const int n = 1 + static_cast<int>(400 * random.uniform(0, 0));
    const double box_m = 0.5 + 8.0 * random.uniform(0, 1);
    const double flat = trial % 3 == 0 ? 0.02 : 1.0;  // sheets as well as clouds
    Points points;
    for (int i = 0; i < n; ++i) {
      const auto r = random.normal3(1, i);
      points.emplace_back(box_m * r[0] - 3.0, box_m * r[1], flat * box_m * r[2]);
      if (i % 17 == 3) points.push_back(points[i / 2]);
    }
    const double tolerance_m = 0.1 + 0.8 * random.uniform(0, 2);
    EXPECT_EQ(by_us(clusters, points, tolerance_m), by_brute_force(points, static_cast<float>(tolerance_m))) << trial;
  }
}

// Tolerances above one meter, and cells whose keys differ only in their leading digits. Points of one place are far
// apart in the list.
TEST(EuclideanClusters, MatchBruteForceOverGreatDistances) {
  EuclideanClusters clusters;
  for (std::uint32_t trial = 0; trial < 40; ++trial) {
    const Random random(trial, "test.far");
    const double tolerance_m = 0.2 * std::pow(30.0, random.uniform(0, 0)), edge_m = 0.577 * tolerance_m;
    Points points;
    for (std::uint32_t i = 0; i < 240; ++i) {
      const auto r = random.normal3(1, i);
      Eigen::Vector3f p;
      for (std::uint32_t axis = 0; axis < 3; ++axis) {
        const double u = random.uniform(2 + i % 60, axis),
                     far = std::exp2(std::floor(20.0 * random.uniform(2 + i % 60, 3 + axis)));
        p[axis] = static_cast<float>(edge_m * ((u < 0.3 ? -far : u < 0.6 ? 0.0 : far - 4.0) + 0.9 * r[axis]));
      }
      points.push_back(p);
    }
    EXPECT_EQ(by_us(clusters, points, tolerance_m), by_brute_force(points, static_cast<float>(tolerance_m))) << trial;
  }
}

// Cells are numbered in 21 bits per axis, less two at either end for their neighbors.
TEST(EuclideanClusters, ExcludePointsAMillionCellsAway) {
  EuclideanClusters clusters;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {-1.0F, 1.0F}) {
      Eigen::Vector3f at = Eigen::Vector3f::Constant(0.5F);
      at[axis] = sign > 0.0F ? 1'048'573.5F : -1'048'572.5F;
      clusters.compute(Points{at}, 1.0 / 0.577);
      EXPECT_EQ(clusters.size(), 1) << at.transpose();
      at[axis] += sign;
      clusters.compute(Points{at}, 1.0 / 0.577);
      EXPECT_EQ(clusters.size(), 0) << at.transpose();
    }
  }
}

TEST(EuclideanClusters, ReachExactlyToTheTolerance) {
  EuclideanClusters clusters;
  for (const Eigen::Vector3f& direction :
       {Eigen::Vector3f(1, 0, 0), Eigen::Vector3f(0, -1, 0), Eigen::Vector3f(0, 0, 1),
        Eigen::Vector3f(1, 1, 1).normalized(), Eigen::Vector3f(-3, 1, 2).normalized()}) {
    for (float start = -1.0F; start < 1.0F; start += 0.0371F) {
      const Eigen::Vector3f at = Eigen::Vector3f::Constant(start);
      clusters.compute(Points{at, at + 0.2499F * direction}, 0.25);
      EXPECT_EQ(clusters.size(), 1);
      clusters.compute(Points{at, at + 0.2501F * direction}, 0.25);
      EXPECT_EQ(clusters.size(), 2);
    }
  }
}

TEST(EuclideanClusters, JoinAChainOfPoints) {
  Points points;
  for (int i = 0; i < 1000; ++i) points.emplace_back(0.2F * static_cast<float>(i), 0.0F, 0.0F);
  EuclideanClusters clusters;
  clusters.compute(points, 0.25);
  EXPECT_EQ(clusters.size(), 1);
  points.erase(points.begin() + 500);
  clusters.compute(points, 0.25);
  ASSERT_EQ(clusters.size(), 2);
  EXPECT_EQ(clusters.members(0).size(), 500U);
  EXPECT_EQ(clusters.members(1).size(), 499U);
}

TEST(EuclideanClusters, LeaveOutWhatIsNoPoint) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  const Points points = {{nan, 0, 0},   {0, 0, 0},    {infinity, 0, 0}, {0, -infinity, 0},
                         {1e30F, 0, 0}, {0.1F, 0, 0}, {0, 0, nan}};
  EuclideanClusters clusters;
  clusters.compute(points, 0.25);
  ASSERT_EQ(clusters.size(), 1);
  EXPECT_EQ(std::vector<std::uint32_t>(clusters.members(0).begin(), clusters.members(0).end()),
            (std::vector<std::uint32_t>{1, 5}));
  clusters.compute({}, 0.25);
  EXPECT_EQ(clusters.size(), 0);
}

TEST(EuclideanClusters, HandleManyDuplicatesAndDenseHeaps) {
  Points points(1'000'000, Eigen::Vector3f(1, 2, 3));
  const Random random(1, "test.heap");
  for (std::uint32_t i = 0; i < 500'000; ++i) {
    const auto r = random.normal3(0, i);
    points.emplace_back(10 + r[0], r[1], r[2]);
  }
  EuclideanClusters clusters;
  clusters.compute(points, 0.25);
  ASSERT_GE(clusters.size(), 2);
  EXPECT_EQ(clusters.members(0).size(), 1'000'000U);
  EXPECT_GT(clusters.members(1).size(), 490'000U);
}

}  // namespace
}  // namespace swiftlet
