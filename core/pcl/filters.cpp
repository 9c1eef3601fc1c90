// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/pcl/filters.hpp"

#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>

#include "core/pcl/clouds.hpp"

namespace swiftlet {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

template <class Filter>
std::vector<std::uint32_t> kept_by(Filter& filter, std::span<const Eigen::Vector3f> points_m) {
  filter.setInputCloud(to_pcl(points_m).makeShared());
  pcl::Indices kept;
  filter.filter(kept);
  return {kept.begin(), kept.end()};
}

}  // namespace

std::vector<Eigen::Vector3f> pcl_voxel_grid(std::span<const Eigen::Vector3f> points_m, double leaf_m) {
  pcl::VoxelGrid<pcl::PointXYZ> filter;
  filter.setInputCloud(to_pcl(points_m).makeShared());
  const auto leaf = static_cast<float>(leaf_m);
  filter.setLeafSize(leaf, leaf, leaf);
  Cloud thinned;
  filter.filter(thinned);
  return points_from_pcl(thinned);
}

std::vector<std::uint32_t> pcl_statistical_inliers(std::span<const Eigen::Vector3f> points_m, int num_neighbors,
                                                   double sigmas) {
  pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
  filter.setMeanK(num_neighbors);
  filter.setStddevMulThresh(sigmas);
  return kept_by(filter, points_m);
}

std::vector<std::uint32_t> pcl_radius_inliers(std::span<const Eigen::Vector3f> points_m, double radius_m,
                                              int min_neighbors) {
  pcl::RadiusOutlierRemoval<pcl::PointXYZ> filter;
  filter.setRadiusSearch(radius_m);
  filter.setMinNeighborsInRadius(min_neighbors);
  return kept_by(filter, points_m);
}

}  // namespace swiftlet
