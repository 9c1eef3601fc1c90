// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/base/scan.hpp"

namespace pcl {
struct PointXYZ;
struct PointXYZI;
struct PointXYZL;
template <class Point>
class PointCloud;
}  // namespace pcl

/// Conversion of scans, clouds and labels to and from PCL clouds. Callers must include PCL's headers; this header does
/// not.
namespace swiftlet {

/// kReturns: a list of points. kImage: one point per beam, in rows and columns, NaN without a return.
enum class PclLayout { kReturns, kImage };

/// Points of a scan in the frame of its LiDAR, as measured, without motion compensation.
pcl::PointCloud<pcl::PointXYZ> to_pcl(const Scan& scan, PclLayout layout = PclLayout::kReturns);
/// to_pcl() with the intensity of each point.
pcl::PointCloud<pcl::PointXYZI> to_pcl_with_intensity(const Scan& scan, PclLayout layout = PclLayout::kReturns);
/// to_pcl() with a label for each point. @param labels  one per beam
pcl::PointCloud<pcl::PointXYZL> to_pcl_with_labels(const Scan& scan, std::span<const std::uint32_t> labels,
                                                   PclLayout layout = PclLayout::kReturns);
/// Any frame, the same for all arguments.
pcl::PointCloud<pcl::PointXYZ> to_pcl(std::span<const Eigen::Vector3f> points_m);

/// Class and instance of each beam in one number, as in SemanticKITTI: the class in the lower 16 bits.
std::vector<std::uint32_t> semantic_labels(std::span<const std::uint16_t> surface_class,
                                           std::span<const std::uint16_t> instance);

/// Finite points, in their order.
std::vector<Eigen::Vector3f> points_from_pcl(const pcl::PointCloud<pcl::PointXYZ>& cloud);
std::vector<Eigen::Vector3f> points_from_pcl(const pcl::PointCloud<pcl::PointXYZI>& cloud);
/// @param labels  labels of the returned points
std::vector<Eigen::Vector3f> points_from_pcl(const pcl::PointCloud<pcl::PointXYZL>& cloud,
                                             std::vector<std::uint32_t>& labels);
/// Sets ranges and intensities of a scan from an image with the same beams; other members are unchanged.
void from_pcl(const pcl::PointCloud<pcl::PointXYZI>& image, Scan& scan);

}  // namespace swiftlet
