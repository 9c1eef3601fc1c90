// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/scan.hpp"

namespace pcl {
struct PointXYZ;
struct PointXYZI;
struct PointXYZL;
template <class Point>
class PointCloud;
}  // namespace pcl

/// Scans, clouds and labels as PCL's clouds and back. Those who call these functions include PCL's own headers; this
/// one does not.
namespace swiftlet {

/// Returns only: a list of points. Image: a point a beam, in rows and columns, NaN where nothing came back.
enum class PclLayout { kReturns, kImage };

/// Points of a scan in the frame of its LiDAR, as measured: the motion during the sweep is in them.
pcl::PointCloud<pcl::PointXYZ> to_pcl(const Scan& scan, PclLayout layout = PclLayout::kReturns);
/// The same with the intensity of each.
pcl::PointCloud<pcl::PointXYZI> to_pcl_with_intensity(const Scan& scan, PclLayout layout = PclLayout::kReturns);
/// The same with a label of each. @param labels  one a beam
pcl::PointCloud<pcl::PointXYZL> to_pcl_with_labels(const Scan& scan, std::span<const std::uint32_t> labels,
                                                   PclLayout layout = PclLayout::kReturns);
/// Any frame, the same for all arguments.
pcl::PointCloud<pcl::PointXYZ> to_pcl(std::span<const Eigen::Vector3f> points_m);

/// Class and instance of each beam in one number, as SemanticKITTI has them: the class in the lower 16 bits.
std::vector<std::uint32_t> semantic_labels(std::span<const std::uint16_t> surface_class,
                                           std::span<const std::uint16_t> instance);

/// Finite points only, in their order.
std::vector<Eigen::Vector3f> points_from_pcl(const pcl::PointCloud<pcl::PointXYZ>& cloud);
std::vector<Eigen::Vector3f> points_from_pcl(const pcl::PointCloud<pcl::PointXYZI>& cloud);
/// @param labels  of the points that are returned
std::vector<Eigen::Vector3f> points_from_pcl(const pcl::PointCloud<pcl::PointXYZL>& cloud,
                                             std::vector<std::uint32_t>& labels);
/// Ranges and intensities of an image whose beams are the scan's; all else in the scan stays as it is.
void from_pcl(const pcl::PointCloud<pcl::PointXYZI>& image, Scan& scan);

}  // namespace swiftlet
