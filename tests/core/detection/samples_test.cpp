// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/samples.hpp"

#include <gtest/gtest.h>

#include <array>

namespace swiftlet {
namespace {

// Two full voxels on a line along x and two with a point each beside it: the box lies along the line.
TEST(ClusterShape, WeightsVoxelsByPointCount) {
  Samples samples;
  samples.at_local_m = {{-1.0F, 0.0F, 0.0F}, {1.0F, 0.0F, 0.0F}, {-1.0F, -1.0F, 0.0F}, {1.0F, 1.0F, 0.0F}};
  samples.weight = {1000, 1000, 1, 1};
  const std::array<std::uint32_t, 4> all = {0, 1, 2, 3};
  const ClusterShape shape = shape_of(samples, all);
  EXPECT_LT(shape.centroid_local_m.norm(), 1e-9);
  EXPECT_NEAR(shape.extent_m.x(), 0.0, 1e-6);
  EXPECT_NEAR(shape.extent_m.y(), 2.0, 0.01);
  EXPECT_NEAR(shape.extent_m.z(), 2.0, 0.01);

  // Without weights the box is rotated towards the diagonal.
  samples.weight.clear();
  EXPECT_GT(shape_of(samples, all).extent_m.z(), 2.5);
}

TEST(Samples, CollectScanPointsPerVoxel) {
  VoxelGrid grid;
  grid.edge_m = 0.5;
  grid.size = {4, 4, 4};
  auto scan = std::make_shared<Scan>();
  LocalCloud cloud;
  cloud.scan = scan;
  cloud.points_local_m = {{0.1F, 0.1F, 0.1F}, {1.6F, 0.1F, 0.1F}, {0.2F, 0.3F, 0.4F}, {9.0F, 0.0F, 0.0F}};
  cloud.beam = {0, 1, 2, 3};
  Samples samples;
  samples.take_points(cloud, grid);
  ASSERT_EQ(samples.size(), 3u);
  EXPECT_EQ(samples.weight_of(2), 1);
  samples.thin_to_voxels(grid);
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples.at_local_m[0], Eigen::Vector3f(0.25F, 0.25F, 0.25F));
  EXPECT_EQ(samples.weight_of(0), 2);
  EXPECT_EQ(samples.weight_of(1), 1);
  EXPECT_EQ(samples.point[1], 1u);
}

}  // namespace
}  // namespace swiftlet
