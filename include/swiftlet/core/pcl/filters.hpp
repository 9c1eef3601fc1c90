// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

/// PCL's filters on the point type of core. Points that are not finite are removed.
/// Any frame, the same for all arguments.
namespace swiftlet {

/// One point for each occupied cube of a grid: the centroid of its points.
std::vector<Eigen::Vector3f> pcl_voxel_grid(std::span<const Eigen::Vector3f> points_m, double leaf_m);

/// Indices of the inliers: points with a mean distance to their neighbors of at most `sigmas` standard deviations above
/// the mean of all points.
std::vector<std::uint32_t> pcl_statistical_inliers(std::span<const Eigen::Vector3f> points_m, int num_neighbors,
                                                   double sigmas);

/// Indices of the points with at least min_neighbors neighbors within the radius.
std::vector<std::uint32_t> pcl_radius_inliers(std::span<const Eigen::Vector3f> points_m, double radius_m,
                                              int min_neighbors);

}  // namespace swiftlet
