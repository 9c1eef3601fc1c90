// SPDX-License-Identifier: BSD-3-Clause
#include "core/tracking/cloud_buffer.hpp"

#include <algorithm>

namespace swiftlet {

void BufferedCloud::assign(const LocalCloud& cloud) {
  stamp_ = cloud.scan->stamp;
  duration_ = cloud.scan->duration;
  beams_ = cloud.scan->beams;
  if (!cloud.T_local_lidar.empty()) T_local_lidar_ = cloud.T_local_lidar[cloud.T_local_lidar.size() / 2];
  points_.clear();
  beam_.clear();
  reflectivity_.clear();
  points_.reserve(cloud.size());
  beam_.reserve(cloud.size());
  reflectivity_.reserve(cloud.size());
  boxes_.clear();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f& p = cloud.points_local_m[i];
    if (!p.allFinite()) continue;  // CloudRegistrar makes finite points only, other makers of clouds may not
    if (points_.size() % kRun == 0) boxes_.push_back({p, p});
    Box& box = boxes_.back();
    box.min_local_m = box.min_local_m.cwiseMin(p);
    box.max_local_m = box.max_local_m.cwiseMax(p);
    points_.push_back(p);
    beam_.push_back(cloud.beam[i]);
    reflectivity_.push_back(cloud.reflectivity_of(i));
  }
}

void BufferedCloud::select(const Vector3& center_local_m, double radius_m, std::vector<std::uint32_t>& indices) const {
  const Eigen::Vector3f center = center_local_m.cast<float>();
  const float radius_sq = static_cast<float>(radius_m * radius_m);
  for (std::size_t b = 0; b < boxes_.size(); ++b) {
    const Eigen::Vector3f nearest = center.cwiseMax(boxes_[b].min_local_m).cwiseMin(boxes_[b].max_local_m);
    if (!((nearest - center).squaredNorm() <= radius_sq)) continue;
    const std::size_t end = std::min(points_.size(), (b + 1) * kRun);
    for (std::size_t i = b * kRun; i < end; ++i) {
      if ((points_[i] - center).squaredNorm() <= radius_sq) indices.push_back(static_cast<std::uint32_t>(i));
    }
  }
}

}  // namespace swiftlet
