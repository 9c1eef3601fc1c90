// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/local_cloud.hpp"

#include <algorithm>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

/// Poses in order of time, with a cursor: the times requested by sweeps hardly ever decrease.
template <class Poses>
class Interpolator {
 public:
  Interpolator(int count, const Poses& poses) : count_(count), poses_(poses) {}
  Pose at(TimeNs t) {
    while (cursor_ > 0 && poses_[cursor_].t > t) --cursor_;
    while (cursor_ + 2 < count_ && poses_[cursor_ + 1].t <= t) ++cursor_;
    return interpolate(poses_[cursor_], poses_[std::min(cursor_ + 1, count_ - 1)], t);
  }

 private:
  int count_;
  int cursor_ = 0;
  const Poses& poses_;
};

template <class Poses>
void place(const Scan& scan, int count, const Poses& poses_in_time, std::vector<Pose>& T_local_lidar) {
  Interpolator poses(count, poses_in_time);
  if (scan.duration == 0) {
    T_local_lidar.assign(scan.cols(), poses.at(scan.stamp) * scan.T_body_lidar);
    return;
  }
  T_local_lidar.resize(scan.cols());
  for (int column = 0; column < scan.cols(); ++column) {
    const TimeNs t = scan.stamp + from_seconds(scan.beams->column_offset_s[column]);
    T_local_lidar[column] = poses.at(t) * scan.T_body_lidar;
  }
}

}  // namespace

void CloudRegistrar::push(const StateEstimate& estimate) {
  poses_.push(estimate);
  to_local_ = FrameChange::to_local(estimate);
}

void CloudRegistrar::place_columns(const Scan& scan, std::vector<Pose>& T_local_lidar) {
  if (scan.external_poses.empty()) {
    place(scan, poses_.size(), poses_, T_local_lidar);
    return;
  }
  external_poses_.clear();
  for (const StampedPose& pose : scan.external_poses)
    external_poses_.push_back({pose.t, to_local_.pose(pose.T_world_body)});
  place(scan, static_cast<int>(external_poses_.size()), external_poses_, T_local_lidar);
}

bool CloudRegistrar::make(std::shared_ptr<const Scan> scan, LocalCloud& cloud) {
  if (scan->external_poses.empty() && poses_.size() == 0) return false;
  cloud.scan = std::move(scan);
  const Scan& s = *cloud.scan;
  const BeamTable& beams = *s.beams;
  const std::size_t size = beams.size();
  ENSURE(s.range_m.size() == size && beams.directions_lidar.size() == size && beams.origins_lidar.size() == size &&
             beams.column_offset_s.size() == static_cast<std::size_t>(beams.cols) &&
             (beams.masked.empty() || beams.masked.size() == size),
         s.sensor, size, s.range_m.size(), beams.directions_lidar.size(), beams.origins_lidar.size(),
         beams.column_offset_s.size(), beams.masked.size());
  place_columns(s, cloud.T_local_lidar);

  const bool has_mask = !beams.masked.empty();
  const float own_radius_sq = static_cast<float>(own_radius_m_ * own_radius_m_);
  const Eigen::Isometry3f T_body_lidar = s.T_body_lidar.cast<float>();
  cloud.points_local_m.clear();
  cloud.beam.clear();
  cloud.points_local_m.reserve(s.size());
  cloud.beam.reserve(s.size());
  std::vector<Pose>::const_iterator T = cloud.T_local_lidar.begin();
  for (int row = 0; row < s.rows(); ++row) {
    for (int column = 0; column < s.cols(); ++column) {
      const int i = row * s.cols() + column;
      if (!s.hit(i) || (has_mask && beams.masked[i])) continue;
      const Eigen::Vector3f p_lidar = s.point_lidar(i);
      if ((T_body_lidar * p_lidar).squaredNorm() < own_radius_sq) continue;
      const Eigen::Vector3f p_local = (T[column] * p_lidar.cast<double>()).cast<float>();
      if (!p_local.allFinite()) continue;
      cloud.points_local_m.push_back(p_local);
      cloud.beam.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return true;
}

std::shared_ptr<const LocalCloud> LocalCloudPool::make(std::shared_ptr<const Scan> scan, CloudRegistrar& registrar) {
  std::shared_ptr<LocalCloud> unused;
  for (const auto& cloud : clouds_) {
    if (cloud.use_count() > 1) continue;
    cloud->scan.reset();  // releases the sensor's memory as well
    unused = cloud;
  }
  if (!unused) unused = clouds_.emplace_back(std::make_shared<LocalCloud>());
  return registrar.make(std::move(scan), *unused) ? unused : nullptr;
}

}  // namespace swiftlet
