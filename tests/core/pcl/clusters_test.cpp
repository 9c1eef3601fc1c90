// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/pcl/clusters.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "swiftlet/core/detection/euclidean_clusters.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/pcl/filters.hpp"
#include "tests/core/pcl/scans.hpp"

namespace swiftlet {
namespace {

using Points = std::vector<Eigen::Vector3f>;

std::vector<std::vector<std::uint32_t>> clusters_by(Clusterer& clusterer, const Points& points, double tolerance_m) {
  clusterer.compute(points, tolerance_m);
  std::vector<std::vector<std::uint32_t>> clusters;
  for (int i = 0; i < clusterer.size(); ++i) {
    clusters.emplace_back(clusterer.members(i).begin(), clusterer.members(i).end());
  }
  return clusters;
}

/// Heaps of points, near and far, with some that are no points.
Points heaps(std::uint32_t trial) {
  const Random random(3, "test.heaps");
  Points points;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const auto r = random.normal3(trial, i);
    const auto heap = static_cast<float>(i % 17);
    points.emplace_back(0.3 * r[0] + 1.4 * heap, 0.3 * r[1] - 0.7 * heap, 0.2 * r[2]);
    if (i % 97 == 0) points.emplace_back(std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F);
  }
  return points;
}

TEST(PclClusters, AreOursInOurOrder) {
  EuclideanClusters ours;
  const auto theirs = make_pcl_clusterer();
  for (std::uint32_t trial = 0; trial < 10; ++trial) {
    const Points points = heaps(trial);
    const auto clusters = clusters_by(*theirs, points, 0.15);
    EXPECT_GT(clusters.size(), 20U);
    EXPECT_EQ(clusters, clusters_by(ours, points, 0.15));
  }
}

TEST(PclClusters, OfASimulatedScanAreOurs) {
  const Points points = testing::scan_hall({2.0, 1.0, 2.0}, 20.0).points_lidar_m;
  EuclideanClusters ours;
  const auto theirs = make_pcl_clusterer();
  EXPECT_EQ(clusters_by(*theirs, points, 0.25), clusters_by(ours, points, 0.25));
}

TEST(PclClusters, OfNothingAreNone) {
  const auto clusterer = make_pcl_clusterer();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(clusters_by(*clusterer, {}, 0.2).empty());
  EXPECT_TRUE(clusters_by(*clusterer, {{nan, nan, nan}}, 0.2).empty());
}

TEST(PclClusters, AreChosenByNameOnceLoaded) {
  plug_in_pcl();
  EXPECT_TRUE(has_clusterer("pcl"));
  EXPECT_EQ(clusters_by(*make_clusterer("pcl"), heaps(0), 0.15),
            clusters_by(*make_clusterer("swiftlet"), heaps(0), 0.15));
  EXPECT_THROW(make_clusterer("unknown"), std::invalid_argument);
}

TEST(PclFilters, LeavesOnePointPerVoxel) {
  const Points points = {{0.1F, 0.1F, 0.1F}, {0.3F, 0.1F, 0.1F}, {1.5F, 0.5F, 0.5F}};
  const Points thinned = pcl_voxel_grid(points, 1.0);
  ASSERT_EQ(thinned.size(), 2U);
  EXPECT_TRUE(thinned[0].isApprox(Eigen::Vector3f(0.2F, 0.1F, 0.1F), 1e-5F));
  EXPECT_EQ(thinned[1], points[2]);
}

TEST(PclFilters, ALonelyPointIsAnOutlier) {
  Points points;
  for (int i = 0; i < 400; ++i) points.emplace_back(0.1F * (i % 20), 0.1F * (i / 20), 0.0F);
  points.emplace_back(1.0F, 1.0F, 5.0F);
  for (const auto& kept : {pcl_statistical_inliers(points, 8, 3.0), pcl_radius_inliers(points, 0.25, 2)}) {
    EXPECT_EQ(kept.size(), 400U);
    EXPECT_EQ(kept.back(), 399U);
  }
}

}  // namespace
}  // namespace swiftlet
