// SPDX-License-Identifier: BSD-3-Clause
#include "core/pcl/clouds.hpp"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <limits>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A point for each return, or for each beam; finish(point, beam) fills the fields beside the position.
template <class Point, class Finish>
pcl::PointCloud<Point> cloud_of(const Scan& scan, PclLayout layout, const Finish& finish) {
  ENSURE(scan.range_m.size() == static_cast<std::size_t>(scan.size()), scan.range_m.size(), scan.size());
  pcl::PointCloud<Point> cloud;
  cloud.reserve(scan.size());
  for (int i = 0; i < scan.size(); ++i) {
    if (!scan.hit(i) && layout == PclLayout::kReturns) continue;
    Point point;
    point.getVector3fMap() = scan.hit(i) ? scan.point_lidar(i) : Eigen::Vector3f::Constant(kNan);
    finish(point, i);
    cloud.push_back(point);
  }
  cloud.is_dense = layout == PclLayout::kReturns;
  if (layout == PclLayout::kImage) {
    cloud.width = scan.cols();
    cloud.height = scan.rows();
  }
  cloud.header.frame_id = scan.sensor;
  cloud.header.stamp = static_cast<std::uint64_t>(scan.stamp / 1000);  // microseconds, as in PCL
  return cloud;
}

template <class Point, class Visit>
void for_each_finite(const pcl::PointCloud<Point>& cloud, const Visit& visit) {
  for (const Point& point : cloud) {
    if (point.getVector3fMap().allFinite()) visit(point);
  }
}

template <class Point>
std::vector<Eigen::Vector3f> points_of(const pcl::PointCloud<Point>& cloud) {
  std::vector<Eigen::Vector3f> points_m;
  points_m.reserve(cloud.size());
  for_each_finite(cloud, [&](const Point& point) { points_m.emplace_back(point.getVector3fMap()); });
  return points_m;
}

}  // namespace

pcl::PointCloud<pcl::PointXYZ> to_pcl(const Scan& scan, PclLayout layout) {
  return cloud_of<pcl::PointXYZ>(scan, layout, [](pcl::PointXYZ&, int) {});
}

pcl::PointCloud<pcl::PointXYZI> to_pcl_with_intensity(const Scan& scan, PclLayout layout) {
  ENSURE(scan.intensity.size() == scan.range_m.size(), scan.intensity.size(), scan.range_m.size());
  return cloud_of<pcl::PointXYZI>(scan, layout,
                                  [&](pcl::PointXYZI& point, int i) { point.intensity = scan.intensity[i]; });
}

pcl::PointCloud<pcl::PointXYZL> to_pcl_with_labels(const Scan& scan, std::span<const std::uint32_t> labels,
                                                   PclLayout layout) {
  ENSURE(labels.size() == scan.range_m.size(), labels.size(), scan.range_m.size());
  return cloud_of<pcl::PointXYZL>(scan, layout, [&](pcl::PointXYZL& point, int i) { point.label = labels[i]; });
}

pcl::PointCloud<pcl::PointXYZ> to_pcl(std::span<const Eigen::Vector3f> points_m) {
  pcl::PointCloud<pcl::PointXYZ> cloud;
  cloud.reserve(points_m.size());
  for (const Eigen::Vector3f& p : points_m) {
    cloud.is_dense = cloud.is_dense && p.allFinite();
    cloud.push_back({p.x(), p.y(), p.z()});
  }
  return cloud;
}

std::vector<std::uint32_t> semantic_labels(std::span<const std::uint16_t> surface_class,
                                           std::span<const std::uint16_t> instance) {
  ENSURE(surface_class.size() == instance.size(), surface_class.size(), instance.size());
  std::vector<std::uint32_t> labels(surface_class.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    labels[i] = surface_class[i] | static_cast<std::uint32_t>(instance[i]) << 16U;
  }
  return labels;
}

std::vector<Eigen::Vector3f> points_from_pcl(const pcl::PointCloud<pcl::PointXYZ>& cloud) { return points_of(cloud); }
std::vector<Eigen::Vector3f> points_from_pcl(const pcl::PointCloud<pcl::PointXYZI>& cloud) { return points_of(cloud); }

std::vector<Eigen::Vector3f> points_from_pcl(const pcl::PointCloud<pcl::PointXYZL>& cloud,
                                             std::vector<std::uint32_t>& labels) {
  labels.clear();
  for_each_finite(cloud, [&](const pcl::PointXYZL& point) { labels.push_back(point.label); });
  return points_of(cloud);
}

void from_pcl(const pcl::PointCloud<pcl::PointXYZI>& image, Scan& scan) {
  const int rows = scan.rows(), cols = scan.cols();
  ENSURE(image.height == static_cast<std::uint32_t>(rows) && image.width == static_cast<std::uint32_t>(cols),
         image.height, image.width, rows, cols);
  scan.range_m.assign(scan.size(), 0.0F);
  scan.intensity.assign(scan.size(), 0.0F);
  for (int i = 0; i < scan.size(); ++i) {
    const pcl::PointXYZI& point = image[i];
    if (!point.getVector3fMap().allFinite()) continue;
    scan.range_m[i] =
        scan.beams->directions_lidar[i].dot(Eigen::Vector3f(point.getVector3fMap()) - scan.beams->origins_lidar[i]);
    scan.intensity[i] = point.intensity;
  }
}

}  // namespace swiftlet
