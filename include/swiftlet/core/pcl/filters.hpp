// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

/// PCL's filters on points as the rest of core has them. What is not finite is left out.
/// Any frame, the same for all arguments.
namespace swiftlet {

/// One point for each occupied cube of a grid: the centroid of its points.
std::vector<Eigen::Vector3f> pcl_voxel_grid(std::span<const Eigen::Vector3f> points_m, double leaf_m);

/// Indices of the points that stay. Those are taken away whose mean distance to their neighbors is more than `sigmas`
/// standard deviations above the mean of all.
std::vector<std::uint32_t> pcl_statistical_inliers(std::span<const Eigen::Vector3f> points_m, int num_neighbors,
                                                   double sigmas);

/// Indices of the points that have at least so many neighbors within the radius.
std::vector<std::uint32_t> pcl_radius_inliers(std::span<const Eigen::Vector3f> points_m, double radius_m,
                                              int min_neighbors);

}  // namespace swiftlet
