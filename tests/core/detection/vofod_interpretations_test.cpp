// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/detection/vofod_stages.hpp"
#include "tests/core/detection/detection_support.hpp"

namespace swiftlet {
namespace {

using namespace testing;

VofodConfig small_box() {
  VofodConfig config;
  config.map.extent = VoxelMapConfig::Extent::kBounded;
  config.map.center_m = {0.0, 0.0, 4.0};
  config.map.size_m = {10.0, 10.0, 8.0};
  return config;
}

/// A detector whose map knows all air as free.
class FreeAir {
 public:
  explicit FreeAir(const VofodConfig& config) : stages(config) {
    for (std::ptrdiff_t i = 0; i < stages.map().grid().num_cells(); ++i) {
      stages.map().set(i, static_cast<float>(config.map.g_free));
    }
  }
  std::vector<Detection> see(const std::vector<Eigen::Vector3f>& points_m, const Vector3& sensor_m = {0, 0, 4}) {
    std::vector<Detection> detections;
    stages.classify(cloud_from(sensor_m, points_m), detections);
    return detections;
  }
  void set(const Cell& cell, double G) { stages.map().set(stages.map().grid().index(cell), static_cast<float>(G)); }
  double G(const Cell& cell) const { return stages.map().value(stages.map().grid().index(cell)); }
  Cell cell_of(const Eigen::Vector3f& p_m) const { return stages.map().grid().cell_of(p_m.cast<double>()); }

  VofodStages stages;
};

const std::vector<Eigen::Vector3f> kInOneVoxel = {{1.1F, 1.1F, 3.1F}, {1.15F, 1.1F, 3.1F}, {1.1F, 1.15F, 3.15F}};

TEST(VofodConfidence, FallsWithUncertainVoxelsInMargin) {
  FreeAir clear(small_box());
  ASSERT_EQ(clear.see(kInOneVoxel).size(), 1u);
  EXPECT_NEAR(FreeAir(small_box()).see(kInOneVoxel)[0].confidence, 1.0, 1e-6);
  const Cell own = clear.cell_of(kInOneVoxel[0]);
  for (int axis = 0; axis < 3; ++axis) {
    for (const int away : {-8, -1, 1, 8}) {
      FreeAir air(small_box());
      Cell cell = own;
      cell[axis] += away;
      air.set(cell, -800.0);  // free still, so that the search passes
      const auto found = air.see(kInOneVoxel);
      ASSERT_EQ(found.size(), 1u);
      EXPECT_EQ(found[0].confidence < 0.99, std::abs(away) == 1) << axis << " " << away;
    }
  }
}

TEST(VofodInterpretations, PlacesDetectionAtCentroidOrCenter) {
  const std::vector<Eigen::Vector3f> points = {{1.0F, 1.0F, 3.0F}, {1.0F, 1.0F, 3.0F}, {1.4F, 1.2F, 3.2F}};
  VofodConfig config = small_box();
  EXPECT_LT((FreeAir(config).see(points)[0].position_m - Vector3(3.4 / 3.0, 3.2 / 3.0, 9.2 / 3.0)).norm(), 1e-6);
  config.choices.position = VofodChoices::Position::kBoxCenter;
  EXPECT_LT((FreeAir(config).see(points)[0].position_m - Vector3(1.2, 1.1, 3.1)).norm(), 1e-6);
  EXPECT_NEAR(FreeAir(config).see(points)[0].extent_m.norm(), std::sqrt(0.24), 1e-6) << "along its own axes";
}

TEST(VofodInterpretations, LimitsOfPointsAndSize) {
  VofodConfig config = small_box();
  config.max_size_m = 0.5;
  const auto count = [&](const std::vector<Eigen::Vector3f>& points_m) { return FreeAir(config).see(points_m).size(); };
  EXPECT_EQ(count({kInOneVoxel[0], kInOneVoxel[1]}), 1u);
  EXPECT_EQ(count({kInOneVoxel[0]}), 0u) << "one point";
  EXPECT_EQ(count({{1.1F, 1.1F, 3.1F}, {1.3F, 1.1F, 3.1F}, {1.58F, 1.1F, 3.1F}}), 1u) << "0.48 m";
  EXPECT_EQ(count({{1.1F, 1.1F, 3.1F}, {1.3F, 1.1F, 3.1F}, {1.62F, 1.1F, 3.1F}}), 0u) << "0.52 m";
}

// Unknown air leads out of a search when it reaches its border: 8 voxels away (the paper), or after about as many steps
// (the released code). A staircase of 8 steps ends 5 voxels away.
TEST(VofodInterpretations, SearchesASphereOrAnOctahedron) {
  for (const auto search : {VofodChoices::Search::kSphere, VofodChoices::Search::kOctahedron}) {
    VofodConfig config = small_box();
    config.search_distance_m = 2.0;
    config.choices.search = search;
    FreeAir staircase(config), straight(config);
    Cell cell = staircase.cell_of(kInOneVoxel[0]), along = cell;
    staircase.set(cell, -740.0);
    straight.set(cell, -740.0);
    for (int step = 0; step < 8; ++step) {
      cell[step % 3] -= 1;
      along.x() -= 1;
      staircase.set(cell, -740.0);
      straight.set(along, -740.0);
    }
    EXPECT_EQ(staircase.see(kInOneVoxel).size(), search == VofodChoices::Search::kSphere ? 1u : 0u);
    EXPECT_EQ(straight.see(kInOneVoxel).size(), 0u);
  }
}

TEST(VofodStages, StampsDetectionsWithMeanPointTime) {
  LocalCloud cloud = cloud_from({0, 0, 4}, kInOneVoxel);
  auto beams = std::make_shared<BeamTable>(*cloud.scan->beams);
  beams->column_offset_s = {0.01F, 0.03F, 0.08F};
  auto scan = std::make_shared<Scan>(*cloud.scan);
  scan->beams = beams;
  scan->stamp = 5'000'000'000;
  scan->duration = 100'000'000;
  scan->reflectivity = {0.2F, 0.7F, 0.4F};
  cloud.scan = scan;
  FreeAir air(small_box());
  std::vector<Detection> found;
  air.stages.classify(cloud, found);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(static_cast<double>(found[0].t), 5.04e9, 100.0);
  EXPECT_EQ(found[0].num_points, 3);
  EXPECT_EQ(found[0].reflectivity, 0.7F);
  EXPECT_LT((found[0].covariance - 0.09 * Matrix3::Identity()).norm(), 1e-12);
}

TEST(VofodStages, CountsEveryPointOfAVoxel) {
  VofodConfig config = small_box();
  config.choices.clustering = VofodChoices::Clustering::kVoxels;
  std::vector<Eigen::Vector3f> points = kInOneVoxel;
  EXPECT_TRUE(FreeAir(config).see(points).empty()) << "one voxel";
  points.emplace_back(1.35F, 1.1F, 3.1F);
  const auto found = FreeAir(config).see(points);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_points, 4);
}

// d_close is 0.7 m to the center of a voxel that is at least tentative.
TEST(VofodInterpretations, TreatsNearbyClustersAsBackground) {
  for (const double G : {-200.0, 0.0}) {
    for (const float away_m : {0.69F, 0.71F}) {
      FreeAir air(small_box());
      const Cell wall = air.cell_of({1.125F, 1.125F, 3.125F});
      air.set(wall, G);
      const std::vector<Eigen::Vector3f> points = {{1.125F + away_m, 1.125F, 3.125F}, {1.9F, 1.125F, 3.13F}};
      const bool is_close = away_m < 0.7F;
      EXPECT_EQ(air.see(points).size(), is_close ? 0u : 1u) << G << " " << away_m;
      std::vector<Eigen::Vector3f> background, flying, unknown;
      air.stages.append_cluster_points(ClusterClass::kBackground, background);
      air.stages.append_cluster_points(ClusterClass::kFlying, flying);
      air.stages.append_cluster_points(ClusterClass::kUnknown, unknown);
      EXPECT_EQ(background.size(), is_close ? 2u : 0u);
      EXPECT_EQ(flying.size(), is_close ? 0u : 2u);
      EXPECT_TRUE(unknown.empty());
      if (is_close) {
        EXPECT_GT(air.G(air.cell_of(points[0])), -501.0)
            << "points of a background cluster raise their voxel above free";
      }
    }
  }
}

TEST(VofodInterpretations, SeedsBackgroundFromTooLargeClusters) {
  for (const VofodSeed seed :
       {VofodSeed::kLargeAndAltimeter, VofodSeed::kLarge, VofodSeed::kAltimeter, VofodSeed::kNone}) {
    for (const float length_m : {2.95F, 3.05F}) {
      VofodConfig config = small_box();
      config.seed = seed;
      FreeAir air(config);
      std::vector<Eigen::Vector3f> points;
      for (int i = 0; i < 6; ++i) points.emplace_back(-1.5F + 0.2F * length_m * static_cast<float>(i), 1.1F, 3.1F);
      const bool large = length_m > 3.0F;
      EXPECT_EQ(air.see(points).size(), large ? 0u : 1u);
      const bool begins = large && (seed == VofodSeed::kLarge || seed == VofodSeed::kLargeAndAltimeter);
      EXPECT_EQ(air.G(air.cell_of(points[2])), begins ? 0.0 : large ? -870.0 : -740.0) << length_m;
      std::vector<Eigen::Vector3f> too_large, unknown;
      air.stages.append_cluster_points(ClusterClass::kTooLarge, too_large);
      air.stages.append_cluster_points(ClusterClass::kUnknown, unknown);
      EXPECT_EQ(too_large.size(), begins ? 6u : 0u);
      EXPECT_EQ(unknown.size(), large && !begins ? 6u : 0u);
    }
  }
}

/// Four beams along x from the middle of a voxel, of a sensor in the middle of an unknown map.
struct Beams {
  explicit Beams(const VofodConfig& config)
      : stages(config), table(std::make_shared<BeamTable>(*make_beams(1, 4, 0.1, -0.1))) {
    for (int i = 0; i < 4; ++i) table->directions_lidar[i] = Eigen::Vector3f::UnitX();
    scan = std::make_shared<Scan>(*scan_world(ground(), pose_at({-3.875, 0.125, 4.125}), table, 0));
    scan->range_m.assign(4, 0.0F);
  }
  void cast() {
    scan->beams = table;
    stages.cast_rays(*cloud_of(std::make_shared<Scan>(*scan)));
  }
  float at(double x_m) const { return stages.map().value_at(stages.map().grid().cell_of({x_m, 0.125, 4.125})); }

  VofodStages stages;
  std::shared_ptr<BeamTable> table;
  std::shared_ptr<Scan> scan;
};

TEST(VofodStages, ClearsRaysUpToLargestLength) {
  for (const float range_m : {0.0F, 8.0F}) {
    VofodConfig config = small_box();
    config.ray_weight = 1.0;
    config.ray_max_m = 5.0;
    Beams beams(config);
    beams.scan->range_m.assign(4, range_m);
    beams.cast();
    beams.stages.apply_rays(1);
    EXPECT_LT(beams.at(0.875), -741.0F) << range_m;
    EXPECT_EQ(beams.at(1.375), -740.0F) << "beyond";
    EXPECT_EQ(beams.at(-4.375), -740.0F) << "behind";
  }
}

TEST(VofodStages, ClearsNothingAlongBeamsHittingItself) {
  VofodConfig config = small_box();
  config.ray_weight = 1.0;
  Beams beams(config);
  beams.table->masked.assign(4, 1);
  beams.cast();
  beams.stages.apply_rays(1);
  EXPECT_EQ(beams.at(0.875), -740.0F);
  beams.table->masked[2] = 0;
  beams.cast();
  beams.stages.apply_rays(1);
  EXPECT_LT(beams.at(0.875), -741.0F);
}

// Four rays through a whole voxel, of which the weight is that of its diagonal.
TEST(VofodStages, WeightsRaysByLengthInVoxel) {
  for (const int num_classifications : {1, 3}) {
    VofodConfig config = small_box();
    config.ray_weight = 0.2;
    Beams beams(config);
    beams.cast();
    beams.stages.apply_rays(num_classifications);
    const double updates = 4.0 * num_classifications * 0.2 / std::sqrt(3.0);
    EXPECT_NEAR(beams.at(0.125), -1000.0 + 260.0 * std::exp2(-updates), 0.5);
  }
}

TEST(VofodStages, ClearsHitVoxelsAlongRays) {
  VofodConfig config = small_box();
  config.ray_weight = 1.0;
  Beams beams(config);
  std::vector<Detection> none;
  beams.cast();
  beams.stages.classify(cloud_from({0, 0, 4}, {{0.125F, 0.125F, 4.125F}}), none);
  const float before = beams.at(0.125);
  beams.stages.apply_rays(1);
  EXPECT_LT(beams.at(0.125), before - 1.0F);
  EXPECT_LT(beams.at(0.375), -741.0F);
}

TEST(VofodStages, ClearsNothingFromOutsideTheMap) {
  VofodConfig config = small_box();
  config.ray_weight = 1.0;
  Beams beams(config);
  beams.scan->external_poses = {{0, pose_at({-5.1, 0.125, 4.125})}};
  beams.cast();
  beams.stages.apply_rays(1);
  EXPECT_EQ(beams.at(-4.875), -740.0F);
}

}  // namespace
}  // namespace swiftlet
