// SPDX-License-Identifier: BSD-3-Clause
#include "core/pcl/clouds.hpp"

#include <gtest/gtest.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include "swiftlet/core/base/ensure.hpp"
#include "tests/core/pcl/scans.hpp"

namespace swiftlet {
namespace {

const testing::HallScan& hall() {
  static const testing::HallScan scan = testing::scan_hall({2.0, 1.0, 2.0}, 20.0);
  return scan;
}

TEST(PclClouds, PreserveScanPointsInOrder) {
  const pcl::PointCloud<pcl::PointXYZ> cloud = to_pcl(hall().labeled->scan);
  ASSERT_GT(cloud.size(), 1000U);
  EXPECT_TRUE(cloud.is_dense);
  EXPECT_EQ(cloud.height, 1U);
  EXPECT_EQ(points_from_pcl(cloud), hall().points_lidar_m);
}

TEST(PclClouds, ImageConvertsBackToTheScan) {
  const Scan& scan = hall().labeled->scan;
  const pcl::PointCloud<pcl::PointXYZI> image = to_pcl_with_intensity(scan, PclLayout::kImage);
  EXPECT_EQ(image.width, static_cast<std::uint32_t>(scan.cols()));
  EXPECT_EQ(image.height, static_cast<std::uint32_t>(scan.rows()));
  EXPECT_FALSE(image.is_dense);
  Scan back = scan;
  back.range_m.clear();
  from_pcl(image, back);
  for (int i = 0; i < scan.size(); ++i) {
    ASSERT_NEAR(back.range_m[i], scan.range_m[i], 1e-4) << i;
    ASSERT_EQ(back.hit(i), scan.hit(i)) << i;
    ASSERT_EQ(back.intensity[i], scan.hit(i) ? scan.intensity[i] : 0.0F) << i;
  }
}

TEST(PclClouds, RejectImagesOfAnotherSize) {
  Scan scan = hall().labeled->scan;
  EXPECT_THROW(from_pcl(to_pcl_with_intensity(scan, PclLayout::kReturns), scan), ContractViolation);
}

TEST(PclClouds, LabelsStayWithTheirPoints) {
  const sim::LabeledScan& labeled = *hall().labeled;
  const auto labels = semantic_labels(labeled.truth.surface_class, labeled.truth.instance);
  std::vector<std::uint32_t> back;
  const auto points = points_from_pcl(to_pcl_with_labels(labeled.scan, labels), back);
  ASSERT_EQ(points, hall().points_lidar_m);
  std::size_t k = 0;
  for (int i = 0; i < labeled.scan.size(); ++i) {
    if (!labeled.scan.hit(i)) continue;
    EXPECT_EQ(back[k] & 0xffffU, labeled.truth.surface_class[i]);
    EXPECT_EQ(back[k] >> 16U, labeled.truth.instance[i]);
    ++k;
  }
  EXPECT_EQ(k, back.size());
}

TEST(PclClouds, DropNonFinitePoints) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Eigen::Vector3f> points = {{1, 2, 3}, {nan, 0, 0}, {4, 5, 6}};
  const pcl::PointCloud<pcl::PointXYZ> cloud = to_pcl(points);
  EXPECT_EQ(cloud.size(), 3U);
  EXPECT_FALSE(cloud.is_dense);
  EXPECT_EQ(points_from_pcl(cloud), (std::vector<Eigen::Vector3f>{{1, 2, 3}, {4, 5, 6}}));
}

}  // namespace
}  // namespace swiftlet
