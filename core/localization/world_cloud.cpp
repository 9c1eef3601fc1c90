// SPDX-License-Identifier: BSD-3-Clause
#include "core/localization/world_cloud.hpp"

#include <algorithm>

#include "swiftlet/core/ensure.hpp"

namespace swiftlet {
namespace {

/// Poses in order of time by index, and a cursor: sweeps ask for times that hardly ever go back.
template <class PoseAt>
class Interpolator {
 public:
  Interpolator(int count, PoseAt pose_at) : count_(count), pose_at_(pose_at) {}
  Pose at(TimeNs t) {
    while (cursor_ > 0 && pose_at_(cursor_).t > t) --cursor_;
    while (cursor_ + 2 < count_ && pose_at_(cursor_ + 1).t <= t) ++cursor_;
    return interpolate(pose_at_(cursor_), pose_at_(std::min(cursor_ + 1, count_ - 1)), t);
  }

 private:
  int count_;
  int cursor_ = 0;
  PoseAt pose_at_;
};

template <class PoseAt>
void place(const Scan& scan, int count, PoseAt pose_at, std::vector<Pose>& T_world_lidar) {
  Interpolator poses(count, pose_at);
  if (scan.duration == 0) {
    T_world_lidar.assign(scan.cols(), poses.at(scan.stamp) * scan.T_body_lidar);
    return;
  }
  T_world_lidar.resize(scan.cols());
  for (int column = 0; column < scan.cols(); ++column) {
    const TimeNs t = scan.stamp + from_seconds(scan.beams->column_offset_s[column]);
    T_world_lidar[column] = poses.at(t) * scan.T_body_lidar;
  }
}

}  // namespace

Pose interpolate(const StampedPose& before, const StampedPose& after, TimeNs t) {
  if (t <= before.t || after.t <= before.t) return before.T_world_body;
  if (t >= after.t) return after.T_world_body;
  const double f = static_cast<double>(t - before.t) / static_cast<double>(after.t - before.t);
  const Eigen::Quaterniond q0(before.T_world_body.linear()), q1(after.T_world_body.linear());
  const Vector3 p0 = before.T_world_body.translation(), p1 = after.T_world_body.translation();
  return make_pose(p0 + f * (p1 - p0), q0.slerp(f, q1));
}

void CloudRegistrar::push(const StateEstimate& estimate) {
  if (!estimate.valid || !estimate.T_world_body.matrix().allFinite()) return;
  if (count_ > 0 && estimate.t <= pose(count_ - 1).t) return;
  if (count_ < kCapacity)
    ++count_;
  else
    first_ = (first_ + 1) % kCapacity;
  ring_[(first_ + count_ - 1) % kCapacity] = {estimate.t, estimate.T_world_body};
}

Pose CloudRegistrar::at(TimeNs t) const {
  ENSURE(count_ > 0, t);
  int after = 0, end = count_;  // the first pose later than t
  while (after < end) {
    const int middle = (after + end) / 2;
    if (pose(middle).t <= t)
      after = middle + 1;
    else
      end = middle;
  }
  return interpolate(pose(std::max(after - 1, 0)), pose(std::min(after, count_ - 1)), t);
}

void CloudRegistrar::place_columns(const Scan& scan, std::vector<Pose>& T_world_lidar) const {
  if (!scan.external_poses.empty()) {
    const auto& told = scan.external_poses;
    place(
        scan, static_cast<int>(told.size()), [&](int i) -> const StampedPose& { return told[i]; }, T_world_lidar);
  } else {
    place(
        scan, count_, [this](int i) -> const StampedPose& { return pose(i); }, T_world_lidar);
  }
}

bool CloudRegistrar::make(std::shared_ptr<const Scan> scan, WorldCloud& cloud) const {
  if (scan->external_poses.empty() && count_ == 0) return false;
  cloud.scan = std::move(scan);
  const Scan& s = *cloud.scan;
  const BeamTable& beams = *s.beams;
  const std::size_t size = beams.size();
  ENSURE(s.range_m.size() == size && beams.directions_lidar.size() == size && beams.origins_lidar.size() == size &&
             beams.column_offset_s.size() == static_cast<std::size_t>(beams.cols) &&
             (beams.masked.empty() || beams.masked.size() == size),
         s.sensor, size, s.range_m.size(), beams.directions_lidar.size(), beams.origins_lidar.size(),
         beams.column_offset_s.size(), beams.masked.size());
  place_columns(s, cloud.T_world_lidar);

  const bool has_mask = !beams.masked.empty();
  const float own_radius_sq = static_cast<float>(own_radius_m_ * own_radius_m_);
  const Eigen::Isometry3f T_body_lidar = s.T_body_lidar.cast<float>();
  cloud.points_world_m.clear();
  cloud.beam.clear();
  cloud.points_world_m.reserve(s.size());
  cloud.beam.reserve(s.size());
  std::vector<Pose>::const_iterator T = cloud.T_world_lidar.begin();
  for (int row = 0; row < s.rows(); ++row) {
    for (int column = 0; column < s.cols(); ++column) {
      const int i = row * s.cols() + column;
      if (!s.hit(i) || (has_mask && beams.masked[i])) continue;
      const Eigen::Vector3f p_lidar = s.point_lidar(i);
      if ((T_body_lidar * p_lidar).squaredNorm() < own_radius_sq) continue;
      const Eigen::Vector3f p_world = (T[column] * p_lidar.cast<double>()).cast<float>();
      if (!p_world.allFinite()) continue;
      cloud.points_world_m.push_back(p_world);
      cloud.beam.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return true;
}

std::shared_ptr<const WorldCloud> WorldCloudPool::make(std::shared_ptr<const Scan> scan,
                                                       const CloudRegistrar& registrar) {
  std::shared_ptr<WorldCloud> unused;
  for (const auto& cloud : clouds_) {
    if (cloud.use_count() > 1) continue;
    cloud->scan.reset();  // lets go of the sensor's memory as well
    unused = cloud;
  }
  if (!unused) unused = clouds_.emplace_back(std::make_shared<WorldCloud>());
  return registrar.make(std::move(scan), *unused) ? unused : nullptr;
}

}  // namespace swiftlet
